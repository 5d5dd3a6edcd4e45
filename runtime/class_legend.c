/* Names and colours of classes. */
#include "runtime/class_legend.h"

#include <ctype.h>
#include <string.h>

typedef struct legend_line {
    const char *name;
    float rgb[3];
} legend_line;

#define RESERVED 0.75f, 0.75f, 0.75f

/* By class number. 8 and 12 are reserved since version 1.4; older files use them. */
static const legend_line lines[] = {
    {"never classified", {RESERVED}},
    {"unclassified", {RESERVED}},
    {"ground", {0.60f, 0.43f, 0.25f}},
    {"low vegetation", {0.60f, 0.80f, 0.35f}},
    {"medium vegetation", {0.35f, 0.65f, 0.25f}},
    {"high vegetation", {0.10f, 0.45f, 0.15f}},
    {"building", {0.85f, 0.35f, 0.25f}},
    {"low noise", {0.90f, 0.20f, 0.80f}},
    {"key point", {RESERVED}},
    {"water", {0.20f, 0.45f, 0.90f}},
    {"rail", {0.55f, 0.50f, 0.60f}},
    {"road", {0.45f, 0.45f, 0.45f}},
    {"overlap", {RESERVED}},
    {"wire guard", {0.95f, 0.85f, 0.30f}},
    {"wire conductor", {0.95f, 0.75f, 0.20f}},
    {"transmission tower", {0.85f, 0.60f, 0.20f}},
    {"wire connector", {0.95f, 0.90f, 0.55f}},
    {"bridge", {0.70f, 0.55f, 0.50f}},
    {"high noise", {0.90f, 0.20f, 0.80f}},
    {"overhead structure", {0.55f, 0.60f, 0.70f}},
    {"ignored ground", {0.50f, 0.35f, 0.20f}},
    {"snow", {0.90f, 0.95f, 1.00f}},
    {"temporal exclusion", {RESERVED}},
};

enum { LINE_COUNT = sizeof lines / sizeof *lines };

const char *stp_class_name(uint8_t class_id)
{
    return class_id < LINE_COUNT ? lines[class_id].name : NULL;
}

/* stp_palette_hash of shaders/shade/palette.glsl. */
static void hash_colour(uint32_t x, float rgb[3])
{
    x = (x ^ x >> 16) * 0x45d9f3bu;
    x = (x ^ x >> 16) * 0x45d9f3bu;
    x = x ^ x >> 16;
    for (int i = 0; i < 3; i++)
        rgb[i] = 0.25f + 0.75f * (float)(x >> 8 * i & 255u) / 255.0f;
}

void stp_class_colour(uint8_t class_id, float rgb[3])
{
    if (class_id < LINE_COUNT)
        memcpy(rgb, lines[class_id].rgb, sizeof lines[class_id].rgb);
    else
        hash_colour(class_id, rgb);
}

static bool same_name(const char *name, const char *text, size_t length)
{
    for (size_t i = 0; i < length; i++) {
        char c = (char)tolower((unsigned char)text[i]);
        if ((c == '-' || c == '_' ? ' ' : c) != name[i]) /* also stops at the end of the name */
            return false;
    }
    return name[length] == '\0';
}

int stp_class_find(const char *name, size_t length)
{
    for (int i = 0; i < LINE_COUNT; i++)
        if (same_name(lines[i].name, name, length))
            return i;
    return -1;
}

stp_status stp_model_classes(const stp_model *model, uint32_t classes[8], stp_error *err)
{
    uint32_t found[8] = {0};
    stp_chunk *root = NULL;
    stp_status status = stp_chunk_file_read(model->file, 0, 0, &root, err);
    if (status != STP_OK)
        return status;
    uint32_t count = root->level_begin[0][root->patch_count];
    for (uint32_t i = 0; i < count; i++) {
        uint8_t id = root->samples[0][i].class_id;
        found[id / 32] |= UINT32_C(1) << id % 32;
    }
    stp_chunk_destroy(&root);
    memcpy(classes, found, sizeof found);
    return STP_OK;
}
