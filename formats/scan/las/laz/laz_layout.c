/* Reads and writes how the points of a LAZ file are packed. */
#include "formats/scan/las/laz/laz_layout.h"

#include "formats/scan/las/las_bytes.h"

#include <string.h>

/* The record: u16 way of packing, u16 coder, u8 u8 u16 version, u32 options, u32 points of a chunk,
 * i64 i64 special records, u16 items; then u16 type, u16 bytes, u16 version of each item. */
#define RECORD_BYTES 34u
#define ITEM_BYTES 6u
enum { AT_VERSION = 4, AT_CHUNK_POINTS = 12, AT_SPECIAL = 16, AT_ITEM_COUNT = 32 };
/* The LASzip that we write like. */
enum { LASZIP_MAJOR = 3, LASZIP_MINOR = 4 };
enum { WAY_POINTS = 1, WAY_CHUNKS = 2, WAY_LAYERS = 3 };

static stp_status take_item(stp_laz_layout *out, const unsigned char *at, const char *path,
                            stp_error *err)
{
    const unsigned type = stp_las_u16(at), bytes = stp_las_u16(at + 2),
                   version = stp_las_u16(at + 4);
    const stp_laz_coder *coder = stp_laz_coder_find(type, version);
    if (!coder)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: its LAZ has an item of type %u in version %u, which this program "
                             "does not know: unpack the file (laszip -i in.laz -o out.las)",
                             path, type, version);
    const bool fits = coder->bytes ? coder->bytes == bytes : bytes > 0;
    if (!fits || (coder->layers > 0) != out->layered)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: its LAZ record has an item of type %u with %u bytes, which does "
                             "not belong there: the file is damaged; copy it again",
                             path, type, bytes);
    if (!coder->bytes && bytes > coder->bytes_most)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: its points have %u extra bytes in LAZ of version %u, and at most "
                             "%u are read: unpack the file (laszip -i in.laz -o out.las)",
                             path, bytes, version, coder->bytes_most);
    out->items[out->item_count].coder = coder;
    out->items[out->item_count++].bytes = bytes;
    return STP_OK;
}

/* Checks that the items make up a record of the header's point format. */
static stp_status check_items(const stp_laz_layout *layout, const stp_las_header *header,
                              const char *path, stp_error *err)
{
    const unsigned type = layout->items[0].coder->type;
    unsigned bytes = 0;
    for (unsigned i = 0; i < layout->item_count; i++)
        bytes += layout->items[i].bytes;
    if (bytes == header->record_bytes &&
        type == (header->format->extended ? STP_LAZ_POINT14 : STP_LAZ_POINT10))
        return STP_OK;
    return stp_error_set(err, STP_CORRUPT,
                         "%s: its LAZ record describes points of %u bytes, its header points of "
                         "format %u with %u bytes: the file is damaged; copy it again",
                         path, bytes, header->point_format, header->record_bytes);
}

stp_status stp_laz_layout_read(stp_laz_layout *out, const stp_las_record *record,
                               const stp_las_header *header, const char *path, stp_error *err)
{
    stp_laz_layout layout = {0};
    const unsigned char *bytes = record->bytes;
    if (record->length < RECORD_BYTES)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: is compressed LAS (LAZ) without the record that says how: the "
                             "file is damaged; copy or export it again",
                             path);
    const unsigned way = stp_las_u16(bytes), coder = stp_las_u16(bytes + 2);
    const unsigned count = stp_las_u16(bytes + AT_ITEM_COUNT);
    if (way < WAY_POINTS || way > WAY_LAYERS || coder != 0)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: its LAZ is packed in way %u with coder %u, which this program "
                             "does not know: unpack the file (laszip -i in.laz -o out.las)",
                             path, way, coder);
    layout.layered = way == WAY_LAYERS;
    layout.chunked = way != WAY_POINTS;
    layout.chunk_points = stp_las_u32(bytes + AT_CHUNK_POINTS);
    if (count == 0 || count > STP_LAZ_ITEMS_MOST ||
        record->length < RECORD_BYTES + count * (size_t)ITEM_BYTES ||
        (layout.chunked && layout.chunk_points == 0))
        return stp_error_set(err, STP_CORRUPT,
                             "%s: its LAZ record names %u items and chunks of %u points: the file "
                             "is damaged; copy or export it again",
                             path, count, layout.chunk_points);
    for (unsigned i = 0; i < count; i++) {
        stp_status status =
            take_item(&layout, bytes + RECORD_BYTES + i * (size_t)ITEM_BYTES, path, err);
        if (status != STP_OK)
            return status;
    }
    stp_status status = check_items(&layout, header, path, err);
    if (status == STP_OK)
        *out = layout;
    return status;
}

unsigned stp_laz_item_layers(const stp_laz_layout *layout, unsigned item)
{
    const stp_laz_coder *coder = layout->items[item].coder;
    return coder->type == STP_LAZ_BYTES14 ? layout->items[item].bytes : coder->layers;
}

/* ---- to write ---- */

static void add_item(stp_laz_layout *layout, const stp_laz_coder *coder, unsigned bytes)
{
    layout->items[layout->item_count].coder = coder;
    layout->items[layout->item_count++].bytes = bytes;
}

stp_status stp_laz_layout_make(stp_laz_layout *out, const stp_las_format *format,
                               unsigned record_bytes, uint32_t chunk_points, const char *path,
                               stp_error *err)
{
    stp_laz_layout layout = {
        .layered = format->extended, .chunked = true, .chunk_points = chunk_points};
    const unsigned extra = record_bytes - format->bytes;
    if (format->wave)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: waveforms cannot be packed as LAZ: write LAS", path);
    if (extra > stp_laz_bytes_v2.bytes_most)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: points have %u extra bytes, and LAZ can have %u: write LAS, or "
                             "fewer attributes",
                             path, extra, stp_laz_bytes_v2.bytes_most);
    if (format->extended) {
        add_item(&layout, &stp_laz_point14_v3, STP_LAZ_POINT14_BYTES);
        if (format->rgb)
            add_item(&layout, format->nir ? &stp_laz_rgbnir14_v3 : &stp_laz_rgb14_v3,
                     format->nir ? 8 : 6);
    } else {
        add_item(&layout, &stp_laz_point10_v2, STP_LAZ_POINT10_BYTES);
        if (format->gps_time)
            add_item(&layout, &stp_laz_time11_v2, 8);
        if (format->rgb)
            add_item(&layout, &stp_laz_rgb12_v2, 6);
    }
    if (extra > 0)
        add_item(&layout, format->extended ? &stp_laz_bytes14_v3 : &stp_laz_bytes_v2, extra);
    *out = layout;
    return STP_OK;
}

size_t stp_laz_layout_put(const stp_laz_layout *layout, unsigned char record[STP_LAZ_RECORD_MOST])
{
    unsigned char *item = record + RECORD_BYTES;
    memset(record, 0, STP_LAZ_RECORD_MOST);
    stp_las_put_u16(record, layout->layered   ? WAY_LAYERS
                            : layout->chunked ? WAY_CHUNKS
                                              : WAY_POINTS);
    record[AT_VERSION] = LASZIP_MAJOR;
    record[AT_VERSION + 1] = LASZIP_MINOR;
    stp_las_put_u32(record + AT_CHUNK_POINTS, layout->chunk_points);
    memset(record + AT_SPECIAL, 0xff, AT_ITEM_COUNT - AT_SPECIAL); /* none */
    stp_las_put_u16(record + AT_ITEM_COUNT, (uint16_t)layout->item_count);
    for (unsigned i = 0; i < layout->item_count; i++, item += ITEM_BYTES) {
        stp_las_put_u16(item, layout->items[i].coder->type);
        stp_las_put_u16(item + 2, (uint16_t)layout->items[i].bytes);
        stp_las_put_u16(item + 4, layout->items[i].coder->version);
    }
    return (size_t)(item - record);
}
