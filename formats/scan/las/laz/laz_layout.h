/* How the points of a LAZ file are packed: the record "laszip encoded". Threads: any. */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_LAZ_LAYOUT_H
#define STP_FORMATS_SCAN_LAS_LAZ_LAZ_LAYOUT_H

#include "base/error.h"
#include "formats/scan/las/las_header.h"
#include "formats/scan/las/las_records.h"
#include "formats/scan/las/laz/laz_item.h"

/* POINT, time, colour, waveform, extra bytes. */
#define STP_LAZ_ITEMS_MOST 5u
/* The longest record that describes them. */
#define STP_LAZ_RECORD_MOST (34u + 6u * STP_LAZ_ITEMS_MOST)

typedef struct stp_laz_layout {
    bool layered;          /* each field of a chunk has its own stream */
    bool chunked;          /* else all points are one chunk, without a table */
    uint32_t chunk_points; /* UINT32_MAX: the table says how many each chunk has */
    unsigned item_count;
    struct {
        const stp_laz_coder *coder;
        unsigned bytes;
    } items[STP_LAZ_ITEMS_MOST];
} stp_laz_layout;

/* Reads the record. Errors: CORRUPT, UNSUPPORTED (a coder that is not known). */
stp_status stp_laz_layout_read(stp_laz_layout *out, const stp_las_record *record,
                               const stp_las_header *header, const char *path, stp_error *err);
/* Layers of an item: the streams of it in a chunk. */
unsigned stp_laz_item_layers(const stp_laz_layout *layout, unsigned item);

/* The layout that we pack points of this format in. Errors: UNSUPPORTED (waveforms; too many extra
 * bytes). */
stp_status stp_laz_layout_make(stp_laz_layout *out, const stp_las_format *format,
                               unsigned record_bytes, uint32_t chunk_points, const char *path,
                               stp_error *err);
/* Writes the record. Returns its bytes. */
size_t stp_laz_layout_put(const stp_laz_layout *layout, unsigned char record[STP_LAZ_RECORD_MOST]);

#endif
