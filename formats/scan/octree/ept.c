/* Reads an Entwine Point Tile set as a stream of points. */
#include "formats/scan/octree/ept.h"

#include "base/memory.h"
#include "formats/scan/las/las_numbers.h"
#include "formats/scan/octree/ept_tile.h"
#include "formats/scan/value_range.h"

#include <stdlib.h>
#include <string.h>

/* Colours and intensities are looked at in this many nodes, spread over the set, and so many points
 * of each one. The first node is the root: its points lie everywhere. */
#define LOOK_NODES 4u
#define LOOK_POINTS 4096u
#define BLOCK_POINTS 512u
#define NOTES_MOST 4u

typedef struct ept_reader {
    stp_ept_files files;
    stp_ept_header header;
    stp_octree_walk walk; /* its nodes are read in order */
    size_t next;          /* node */
    stp_ept_tile tile;
    stp_las_depth depth;
    bool keeps_numbers;
    stp_las_numbers numbers;
    uint8_t *packed; /* numbers of the points read last */
    size_t packed_capacity;
    stp_las_text counts;
    stp_scan_note notes[NOTES_MOST];
} ept_reader;

/* ---- the hierarchy ---- */

static stp_status bad_entry(const char *name, const char *key, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT,
                         "%s: its entry `%.40s` is no node D-X-Y-Z with a number of points, or -1: "
                         "the file is damaged; copy it again",
                         name, key);
}

/* Parses "D-X-Y-Z". */
static bool parse_key(const char *text, stp_octree_key *key)
{
    uint32_t *const parts[4] = {&key->depth, &key->x, &key->y, &key->z};
    for (int i = 0; i < 4; i++) {
        uint64_t number = 0;
        size_t digits = 0;
        for (; digits < 10 && text[digits] >= '0' && text[digits] <= '9'; digits++)
            number = 10 * number + (uint64_t)(text[digits] - '0');
        text += digits;
        if (digits == 0 || number > UINT32_MAX || *text != (i < 3 ? '-' : '\0'))
            return false;
        *parts[i] = (uint32_t)number;
        text++;
    }
    return true;
}

static stp_status read_page(void *context, stp_octree_walk *walk, const stp_octree_node *page,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const ept_reader *ept = context;
    cJSON *json = NULL, *entry = NULL;
    char *name = NULL;
    STP_TRY(stp_ept_files_json(&ept->files, &page->key, &json, &name, err));
    walk->where = name;
    cJSON_ArrayForEach(entry, json)
    {
        stp_octree_node node = {0};
        const double count = cJSON_IsNumber(entry) ? entry->valuedouble : -2.0;
        if (!parse_key(entry->string, &node.key) || !(count >= -1.0 && count <= UINT32_MAX) ||
            count != (double)(int64_t)count) {
            status = bad_entry(name, entry->string, err);
            goto done;
        }
        node.count = count > 0.0 ? (uint32_t)count : 0;
        STP_TRY(stp_octree_walk_add(walk, &node, count < 0.0, err));
    }
done:
    cJSON_Delete(json);
    free(name);
    return status;
}

/* ---- opening ---- */

static stp_status find_depth(ept_reader *ept, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t total = ept->walk.nodes.count, nodes = total < LOOK_NODES ? total : LOOK_NODES;
    stp_las_seen seen = {0};
    stp_point points[BLOCK_POINTS];
    for (size_t i = 0; i < nodes; i++) {
        size_t count = 1;
        STP_TRY(stp_ept_tile_open(&ept->tile,
                                  &ept->walk.nodes.nodes[stp_spread_begin(total, i, nodes)], err));
        for (size_t done = 0; done < LOOK_POINTS && count > 0; done += count)
            STP_TRY(stp_ept_tile_read(&ept->tile, &ept->depth, points, BLOCK_POINTS, &count, &seen,
                                      err));
    }
    ept->depth = stp_las_depth_decide(&seen);
    ept->tile.left = 0;
done:
    return status;
}

/* The attributes: of laszip those of the tile that is open. */
static void numbers_of(const ept_reader *ept, stp_las_numbers *out)
{
    if (ept->header.packing == STP_EPT_LASZIP) {
        stp_las_numbers_of_file(out, &ept->tile.las.header, &ept->tile.las.records, &ept->depth,
                                ept->header.keeps_withheld);
        return;
    }
    *out = ept->header.numbers;
    stp_las_numbers_relate(out, &ept->depth);
}

/* Whether the tile that is open has the attributes of the set. */
static stp_status check_numbers(const ept_reader *ept, stp_error *err)
{
    stp_las_numbers own;
    numbers_of(ept, &own);
    bool same = own.list.count == ept->numbers.list.count;
    for (uint32_t i = 0; same && i < own.list.count; i++)
        same = strcmp(own.list.items[i].name, ept->numbers.list.items[i].name) == 0 &&
               own.list.items[i].type == ept->numbers.list.items[i].type &&
               memcmp(&own.fields[i], &ept->numbers.fields[i], sizeof own.fields[i]) == 0;
    if (same)
        return STP_OK;
    return stp_error_set(err, STP_CORRUPT,
                         "%s: its points have other fields than those of other tiles: it is of "
                         "another set; copy the whole set again",
                         ept->tile.file.name);
}

static void note(ept_reader *ept, stp_scan_info *info, const char *name, const stp_las_text *text)
{
    if (text->length > 0)
        ept->notes[info->note_count++] = (stp_scan_note){name, text->bytes};
}

static stp_status make_notes(ept_reader *ept, stp_scan_info *info, stp_error *err)
{
    stp_status status = STP_OK;
    const bool all = ept->walk.region == NULL;
    if (all && ept->walk.points != ept->header.point_count)
        STP_TRY(stp_las_text_add(
            &ept->counts, err, "ept.json says %llu points, its hierarchy %llu: those were read",
            (unsigned long long)ept->header.point_count, (unsigned long long)ept->walk.points));
    note(ept, info, "wkt", &ept->header.wkt);
    note(ept, info, "geokeys", &ept->header.keys);
    if (!ept->keeps_numbers)
        note(ept, info, "left_out", &ept->header.left_out);
    note(ept, info, "counts", &ept->counts);
    info->notes = ept->notes;
done:
    return status;
}

static uint32_t attributes_of(const ept_reader *ept)
{
    const stp_ept_header *h = &ept->header;
    const bool las = h->packing == STP_EPT_LASZIP;
    uint32_t attributes = 0;
    if (stp_ept_has_colours(h) && ept->depth.colour != STP_LAS_COLOUR_NONE)
        attributes |= STP_POINT_HAS_COLOUR;
    if (las || stp_ept_has(h, STP_EPT_INTENSITY))
        attributes |= STP_POINT_HAS_INTENSITY;
    if (las || stp_ept_has(h, STP_EPT_CLASS))
        attributes |= STP_POINT_HAS_CLASS;
    if (stp_ept_has_normals(h))
        attributes |= STP_POINT_HAS_NORMAL;
    return attributes;
}

static stp_status open_reader(void *state, stp_scan_info *info, const char *path,
                              const stp_scan_params *params, stp_error *err)
{
    static const char *const names[] = {"EPT laszip", "EPT binary", "EPT zstandard"};
    stp_status status = STP_OK;
    ept_reader *ept = state;
    const stp_octree_node root = {0};
    cJSON *json = NULL;
    char *name = NULL;
    ept->tile.las.source.descriptor = ept->tile.source.descriptor = -1;
    ept->files = stp_ept_files_of(path, params->web);
    STP_TRY(stp_ept_files_json(&ept->files, NULL, &json, &name, err));
    ept->header.keeps_withheld = params->keep_withheld;
    STP_TRY(stp_ept_header_read(&ept->header, json, name, err));
    ept->tile.header = &ept->header;
    ept->tile.files = &ept->files;
    ept->tile.all_fields = ept->keeps_numbers = params->numbers;
    ept->walk =
        (stp_octree_walk){.octree = &ept->header.octree, .region = params->region, .where = name};
    STP_TRY(stp_octree_walk_run(&ept->walk, &root, read_page, ept, err));
    STP_TRY(find_depth(ept, err));
    if (ept->walk.nodes.count > 0)
        numbers_of(ept, &ept->numbers); /* of the tile that find_depth looked at last */
    STP_TRY(make_notes(ept, info, err));
    info->format = names[ept->header.packing];
    info->point_count = ept->walk.points;
    info->attributes = attributes_of(ept);
    info->octree_spacing = ept->header.octree.spacing;
    info->heights = true;
    info->intensity_full = ept->depth.intensity_8 ? 255.0 : 65535.0;
    info->coordinate_step = ept->header.step;
    info->extra = ept->numbers.list.count > 0 ? &ept->numbers.list : NULL;
done:
    ept->walk.where = NULL;
    cJSON_Delete(json);
    free(name);
    return status;
}

/* ---- reading ---- */

static stp_status read_points(void *state, stp_point *points, size_t capacity, size_t *count,
                              stp_error *err)
{
    stp_status status = STP_OK;
    ept_reader *ept = state;
    size_t done_count = 0;
    const size_t stride = stp_attribute_list_bytes(&ept->numbers.list);
    if (ept->keeps_numbers)
        STP_TRY(
            stp_grow(&ept->packed, &ept->packed_capacity, capacity * stride, 1, "attributes", err));
    while (done_count < capacity) {
        size_t part = 0;
        if (ept->tile.left == 0 && ept->next == ept->walk.nodes.count)
            break;
        if (ept->tile.left == 0) {
            STP_TRY(stp_ept_tile_open(&ept->tile, &ept->walk.nodes.nodes[ept->next++], err));
            if (ept->keeps_numbers)
                STP_TRY(check_numbers(ept, err));
        }
        STP_TRY(stp_ept_tile_read(&ept->tile, &ept->depth, points + done_count,
                                  capacity - done_count, &part, NULL, err));
        if (ept->keeps_numbers && part > 0)
            stp_las_numbers_pack(&ept->numbers, ept->tile.read, ept->tile.read_bytes, part,
                                 ept->packed + done_count * stride);
        done_count += part;
    }
    *count = done_count;
done:
    return status;
}

static void close_reader(void *state)
{
    ept_reader *ept = state;
    stp_ept_tile_close(&ept->tile);
    stp_octree_walk_free(&ept->walk);
    stp_las_text_free(&ept->counts);
    stp_ept_header_free(&ept->header);
    free(ept->packed);
}

static const uint8_t *numbers_read(const void *state)
{
    return ((const ept_reader *)state)->packed;
}

const stp_scan_reader stp_ept_reader = {.state_bytes = sizeof(ept_reader),
                                        .open = open_reader,
                                        .read = read_points,
                                        .close = close_reader,
                                        .numbers = numbers_read};
