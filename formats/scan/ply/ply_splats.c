/* Reads packed Gaussian splats. */
#include "formats/scan/ply/ply_splats.h"

#include "base/memory.h"

#include <stdio.h>
#include <string.h>

/* Vertices of a chunk. */
#define SPLATS 256u

/* So many bits from bit `low` on, and where they go. */
static const struct {
    unsigned low, bits;
    stp_ply_target to;
} parts[6] = {{21, 11, STP_PLY_X},  {11, 10, STP_PLY_Y},    {0, 11, STP_PLY_Z},
              {24, 8, STP_PLY_RED}, {16, 8, STP_PLY_GREEN}, {8, 8, STP_PLY_BLUE}};

bool stp_ply_splats_find(stp_ply *ply)
{
    const stp_ply_header *h = &ply->header;
    ply->packed = stp_ply_number_property(h, ply->vertex, "packed_position") != NULL;
    for (size_t i = 0; i < ply->vertex->property_count && ply->packed; i++) {
        stp_ply_property *p = &h->properties[ply->vertex->property_first + i];
        if (p->type == STP_PLY_UINT32 && strcmp(p->name, "packed_position") == 0)
            p->target = STP_PLY_X;
        if (p->type == STP_PLY_UINT32 && strcmp(p->name, "packed_color") == 0)
            p->target = STP_PLY_RED;
    }
    return ply->packed;
}

/* The place in stp_ply_splats of a property of a chunk: 0 to 5 of min, 6 to 11 of max; 12: none. */
static unsigned place_of(const stp_ply_property *property)
{
    static const char axes[] = "xyzrgb";
    char known[8];
    for (unsigned i = 0; i < 12; i++) {
        snprintf(known, sizeof known, "%s_%c", i < 6 ? "min" : "max", axes[i % 6]);
        if (!property->is_list && strcmp(known, property->name) == 0)
            return i;
    }
    return 12;
}

/* Bits of the places of positions. */
#define RANGES 0x1c7u

stp_status stp_ply_splats_read(stp_ply *ply, const stp_ply_element *element, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ply_cursor *c = &ply->cursor;
    c->element = element;
    c->index = 0;
    unsigned found = 0;
    for (size_t i = 0; i < element->property_count; i++)
        found |= 1u << place_of(&ply->header.properties[element->property_first + i]);
    if ((found & RANGES) != RANGES)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: the PLY element `chunk` of packed Gaussian splats lacks one of "
                             "min_x, min_y, min_z, max_x, max_y, max_z: export the file again",
                             ply->source.path);
    /* in ASCII, too, a record of so many properties is no smaller */
    const uint64_t fit = (ply->source.size - ply->source.offset) / (2 * element->property_count);
    if (element->count > fit)
        return stp_ply_cut(c, err);
    STP_TRY(stp_alloc(&ply->splats, (size_t)element->count, sizeof *ply->splats, "chunks of splats",
                      err));
    while (c->index < element->count) {
        stp_ply_splats *s = &ply->splats[c->index];
        *s = (stp_ply_splats){.max = {0.0, 0.0, 0.0, 1.0, 1.0, 1.0}};
        STP_TRY(stp_ply_record_begin(c, err));
        for (size_t i = 0; i < element->property_count; i++) {
            const stp_ply_property *p = &ply->header.properties[element->property_first + i];
            const unsigned place = place_of(p);
            if (place == 12)
                STP_TRY(stp_ply_skip_property(c, p, err));
            else
                STP_TRY(stp_ply_next_value(c, p->type,
                                           place < 6 ? &s->min[place] : &s->max[place - 6], err));
        }
        STP_TRY(stp_ply_record_end(c, err));
    }
    ply->splat_chunks = element->count;
done:
    return status;
}

stp_status stp_ply_splats_check(const stp_ply *ply, stp_error *err)
{
    if (!ply->packed || ply->vertex->count <= SPLATS * ply->splat_chunks)
        return STP_OK;
    return stp_error_set(err, STP_CORRUPT,
                         "%s: %llu packed Gaussian splats need %llu records of the element `chunk` "
                         "before them, and there are %llu: export the file again",
                         ply->source.path, (unsigned long long)ply->vertex->count,
                         (unsigned long long)((ply->vertex->count - 1) / SPLATS + 1),
                         (unsigned long long)ply->splat_chunks);
}

/* ASCII may have numbers that are no words. */
static uint32_t word_of(double number)
{
    return number >= 0.0 && number < 0x1p32 ? (uint32_t)number : 0;
}

void stp_ply_splats_part(stp_ply *ply, uint64_t first, size_t count)
{
    const bool coloured = ply->attributes & STP_POINT_HAS_COLOUR;
    for (size_t i = 0; i < count; i++) {
        const stp_ply_splats *s = &ply->splats[(first + i) / SPLATS];
        const uint32_t words[2] = {word_of(ply->columns[STP_PLY_X][i]),
                                   coloured ? word_of(ply->columns[STP_PLY_RED][i]) : 0};
        for (unsigned k = 0; k < (coloured ? 6 : 3); k++) {
            const uint32_t most = (1u << parts[k].bits) - 1u;
            const double share = (double)(words[k / 3] >> parts[k].low & most) / most;
            ply->columns[parts[k].to][i] = s->min[k] + share * (s->max[k] - s->min[k]);
        }
    }
}
