// Reads an image of floats with OpenImageIO, as a C function.
#include "tests/support/exr_shim.h"

#include <OpenImageIO/imageio.h>

#include <cstdio>
#include <cstdlib>

int exr_image_read(const char *path, exr_image *out)
{
    float *values = nullptr;
    try {
        auto input = OIIO::ImageInput::open(path);
        if (!input || input->spec().format != OIIO::TypeDesc::FLOAT)
            return -1;
        const OIIO::ImageSpec &spec = input->spec();
        std::string names;
        for (const std::string &name : spec.channelnames)
            names += (names.empty() ? "" : " ") + name;
        size_t count = spec.image_pixels() * static_cast<size_t>(spec.nchannels);
        values = static_cast<float *>(std::malloc(count * sizeof *values));
        if (!values || !input->read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, values)) {
            std::free(values);
            return -1;
        }
        out->width = spec.width;
        out->height = spec.height;
        out->channel_count = spec.nchannels;
        std::snprintf(out->channels, sizeof out->channels, "%s", names.c_str());
        std::snprintf(out->camera, sizeof out->camera, "%s",
                      spec.get_string_attribute("stipple:camera").c_str());
        out->values = values;
        return 0;
    } catch (...) {
        std::free(values);
        return -1;
    }
}
