/* Reads colours of binary STL's facets. */
#include "formats/scan/mesh/stl_colours.h"

#include "base/memory.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define HEADER_BYTES 80u /* a count follows */
#define FIRST_FACET 84u
#define FACET_BYTES 50u
#define WORD_AT 48u
#define OWN 0x8000u

/* Materialise's colour of the whole; NULL: it did not write the file. */
static const unsigned char *whole_colour(const stp_mesh_text *text)
{
    const char *found = memmem(text->data, HEADER_BYTES - 4, "COLOR=", 6);
    return found && found + 10 <= text->data + HEADER_BYTES ? (const unsigned char *)found + 6
                                                            : NULL;
}

/* False: the facet has no colour. */
static bool colour_of(uint16_t rgb[3], unsigned word, const unsigned char *whole)
{
    for (int k = 0; k < 3; k++) {
        const int shift = whole ? 5 * k : 10 - 5 * k;
        rgb[k] = (uint16_t)((word >> shift & 31u) * 65535u / 31u);
        if (whole && word & OWN)
            rgb[k] = (uint16_t)(whole[k] * 257u);
    }
    return whole || word & OWN;
}

/* As OpenMesh, which leaves out such facets. */
static bool corners_coincide(const char *facet)
{
    float v[9];
    memcpy(v, facet + 12, sizeof v);
    for (int a = 0; a < 3; a++) {
        const float *p = v + 3 * a, *q = v + 3 * ((a + 1) % 3);
        if (fabsf(p[0] - q[0]) <= FLT_MIN && fabsf(p[1] - q[1]) <= FLT_MIN &&
            fabsf(p[2] - q[2]) <= FLT_MIN)
            return true;
    }
    return false;
}

static unsigned word_of(const char *facet)
{
    const unsigned char *word = (const unsigned char *)facet + WORD_AT;
    return word[0] | (unsigned)word[1] << 8;
}

stp_status stp_stl_colours_add(const stp_mesh_text *text, stp_materials *materials, stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned char *whole = whole_colour(text);
    const char *facets = text->data + FIRST_FACET;
    uint32_t count; /* other bytes may follow the facets */
    uint16_t rgb[3];
    bool any = false;
    memcpy(&count, text->data + HEADER_BYTES, sizeof count);
    for (size_t i = 0; i < count && !any; i++)
        any = colour_of(rgb, word_of(facets + i * FACET_BYTES), whole);
    for (size_t i = 0; i < count && any; i++) {
        const char *facet = facets + i * FACET_BYTES;
        const bool coloured = colour_of(rgb, word_of(facet), whole);
        if (!corners_coincide(facet))
            STP_TRY(stp_materials_add_plain(materials, coloured ? rgb : NULL, 1, err));
    }
done:
    return status;
}
