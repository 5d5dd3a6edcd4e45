/* OpenImageIO as C. */
extern "C" {
#include "formats/image/image_shim.h"
}

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace
{
void say(char *message, size_t bytes, const std::string &text)
{
    std::snprintf(message, bytes, "%s", text.substr(0, text.find('\n')).c_str());
}

/* Spreads 1 to 4 channels of 8 bits over RGBA. Works from the end, so that it can work in place. */
void spread(uint8_t *pixels, size_t count, int channels)
{
    for (size_t i = count; i-- > 0;) {
        const uint8_t *in = pixels + i * static_cast<size_t>(channels);
        uint8_t grey = in[0];
        uint8_t g = channels > 2 ? in[1] : grey;
        uint8_t b = channels > 2 ? in[2] : grey;
        uint8_t a = channels == 4 ? in[3] : channels == 2 ? in[1] : uint8_t(255);
        uint8_t *out = pixels + i * 4;
        out[0] = grey;
        out[1] = g;
        out[2] = b;
        out[3] = a;
    }
}

/* Returns NULL and a message if the format is unknown. */
std::unique_ptr<OIIO::ImageOutput> create(const char *format_name, char *message,
                                          size_t message_bytes)
{
    auto output = OIIO::ImageOutput::create(format_name);
    if (!output)
        say(message, message_bytes, OIIO::geterror());
    return output;
}

/* Opens, writes and closes. Formats that can (PNG, EXR) write through our stream, and its errors
 * are checked at the end: libpng does not report errors, so a full disk would go unnoticed. */
stp_oiio_result write(OIIO::ImageOutput &output, const OIIO::ImageSpec &spec, const char *path,
                      const OIIO::TypeDesc &type, const void *values, OIIO::stride_t pixel,
                      char *message, size_t message_bytes)
{
    FILE *file = output.supports("ioproxy") ? std::fopen(path, "wb") : nullptr;
    int reason = 0;
    {
        OIIO::Filesystem::IOFile stream(file, OIIO::Filesystem::IOProxy::Write);
        if (file)
            output.set_ioproxy(&stream);
        if (!output.open(path, spec) || !output.write_image(type, values, pixel) ||
            !output.close()) {
            say(message, message_bytes, output.geterror());
            reason = EIO;
        }
        if (file && (std::fflush(file) != 0 || std::ferror(file)))
            reason = errno == ENOSPC || errno == EDQUOT ? ENOSPC : EIO;
        output.close();
    }
    if (file && std::fclose(file) != 0 && reason == 0)
        reason = errno;
    if (reason != 0 && message[0] == '\0')
        say(message, message_bytes, "it could not be written whole");
    return reason == 0 ? STP_OIIO_OK : reason == ENOSPC ? STP_OIIO_DISK_FULL : STP_OIIO_FAILED;
}
} // namespace

extern "C" stp_oiio_result stp_oiio_load(const char *path, int *width, int *height, uint8_t **rgba,
                                         char *message, size_t message_bytes)
{
    uint8_t *pixels = nullptr;
    try {
        OIIO::ImageSpec config;
        config["oiio:UnassociatedAlpha"] = 1;
        auto input = OIIO::ImageInput::open(path, &config);
        if (!input) {
            say(message, message_bytes, OIIO::geterror());
            return STP_OIIO_UNKNOWN_FORMAT;
        }
        const OIIO::ImageSpec &spec = input->spec();
        int channels = spec.nchannels < 4 ? spec.nchannels : 4;
        size_t count = static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height);
        pixels = static_cast<uint8_t *>(std::malloc(count ? count * 4 : 1));
        if (!pixels)
            return STP_OIIO_NO_MEMORY;
        if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::UINT8, pixels)) {
            say(message, message_bytes, input->geterror());
            std::free(pixels);
            return STP_OIIO_DAMAGED;
        }
        spread(pixels, count, channels);
        *width = spec.width;
        *height = spec.height;
        *rgba = pixels;
        return STP_OIIO_OK;
    } catch (...) {
        std::free(pixels);
        return STP_OIIO_FAILED;
    }
}

struct stp_oiio_heights {
    std::unique_ptr<OIIO::ImageInput> input;
    int channel;
};

namespace
{
/* Rows that are compressed together; EXR alone matters here. */
int band_of(const OIIO::ImageSpec &spec)
{
    const OIIO::string_view how = spec.get_string_attribute("compression");
    if (spec.tile_height > 0)
        return spec.tile_height;
    if (OIIO::Strutil::starts_with(how, "zips") || how == "none" || how == "rle")
        return 1;
    if (OIIO::Strutil::starts_with(how, "zip") || how == "pxr24")
        return 16;
    return OIIO::Strutil::starts_with(how, "dwab") ? 256 : 32;
}
} // namespace

extern "C" stp_oiio_result stp_oiio_open_heights(stp_oiio_heights **out, const char *path,
                                                 int *width, int *height, int *band, char *message,
                                                 size_t message_bytes)
{
    try {
        auto input = OIIO::ImageInput::open(path);
        if (!input) {
            say(message, message_bytes, OIIO::geterror());
            return STP_OIIO_UNKNOWN_FORMAT;
        }
        const OIIO::ImageSpec &spec = input->spec();
        int channel = spec.nchannels == 1 ? 0 : -1;
        for (int i = 0; channel < 0 && i < spec.nchannels; i++) {
            const std::string &all = spec.channelnames[static_cast<size_t>(i)];
            const std::string own = all.substr(all.rfind('.') + 1); /* without its layer */
            for (const char *name : {"Z", "depth", "height", "Y"})
                if (OIIO::Strutil::iequals(own, name))
                    channel = i;
        }
        if (channel < 0) {
            say(message, message_bytes, "none of its channels is named Z, depth or height");
            return STP_OIIO_UNKNOWN_FORMAT;
        }
        *width = spec.width;
        *height = spec.height;
        *band = band_of(spec);
        *out = new stp_oiio_heights{std::move(input), channel};
        return STP_OIIO_OK;
    } catch (...) {
        return STP_OIIO_FAILED;
    }
}

extern "C" stp_oiio_result stp_oiio_read_heights(stp_oiio_heights *image, int begin, int end,
                                                 float *heights, char *message,
                                                 size_t message_bytes)
{
    try {
        OIIO::ImageInput &input = *image->input;
        const int y = input.spec().y; /* of the first row */
        if (input.read_scanlines(0, 0, y + begin, y + end, 0, image->channel, image->channel + 1,
                                 OIIO::TypeDesc::FLOAT, heights))
            return STP_OIIO_OK;
        say(message, message_bytes, input.geterror());
        return STP_OIIO_DAMAGED;
    } catch (...) {
        return STP_OIIO_FAILED;
    }
}

extern "C" void stp_oiio_close_heights(stp_oiio_heights *image)
{
    try {
        delete image;
    } catch (...) {
    }
}

extern "C" stp_oiio_result stp_oiio_save(const char *path, const char *format_name, int width,
                                         int height, const uint8_t *rgba, char *message,
                                         size_t message_bytes)
{
    try {
        auto output = create(format_name, message, message_bytes);
        if (!output)
            return STP_OIIO_UNKNOWN_FORMAT;
        OIIO::ImageSpec spec(width, height, 4, OIIO::TypeDesc::UINT8);
        spec["oiio:UnassociatedAlpha"] = 1;
        std::vector<uint8_t> shown;
        if (!output->supports("alpha")) {
            spec.nchannels = 3;
            shown.assign(rgba, rgba + 4 * spec.image_pixels());
            for (size_t i = 0; i < shown.size(); i++)
                shown[i] = static_cast<uint8_t>((shown[i] * rgba[i | 3] + 127) / 255);
            rgba = shown.data();
        }
        const OIIO::stride_t pixel = 4;
        return write(*output, spec, path, OIIO::TypeDesc::UINT8, rgba, pixel, message,
                     message_bytes);
    } catch (...) {
        return STP_OIIO_FAILED;
    }
}

extern "C" stp_oiio_result stp_oiio_save_floats(const char *path, const char *format_name,
                                                const stp_float_image *image, char *message,
                                                size_t message_bytes)
{
    try {
        auto output = create(format_name, message, message_bytes);
        if (!output)
            return STP_OIIO_UNKNOWN_FORMAT;
        OIIO::ImageSpec spec(image->width, image->height, image->channel_count,
                             OIIO::TypeDesc::FLOAT);
        spec.channelnames.assign(image->channel_names, image->channel_names + image->channel_count);
        spec["compression"] = "zip";
        spec["DateTime"] = ""; /* without this it is the present time, and the same image would not
                                  give the same bytes */
        for (size_t i = 0; i < image->note_count; i++)
            spec[image->notes[i].name] = image->notes[i].text;
        return write(*output, spec, path, OIIO::TypeDesc::FLOAT, image->values, OIIO::AutoStride,
                     message, message_bytes);
    } catch (...) {
        return STP_OIIO_FAILED;
    }
}
