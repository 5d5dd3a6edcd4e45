/* Makes the notes of a LAS file. */
#include "formats/scan/las/las_notes.h"

#include "formats/scan/las/las_geokeys.h"

#include <math.h>

/* Layout of the record that describes extra bytes. */
enum { EXTRA_RECORD_BYTES = 192, AT_EXTRA_NAME = 4, EXTRA_NAME_BYTES = 32 };

/* Makes the next text a note, if it is not empty. */
static void take(stp_las_notes *out, const char *name)
{
    if (out->texts[out->count].length > 0) {
        out->list[out->count] = (stp_scan_note){name, out->texts[out->count].bytes};
        out->count++;
    }
}

static stp_status add_extra(stp_las_text *text, const stp_las_header *header,
                            const stp_las_records *records, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_las_record *record = &records->kept[STP_LAS_EXTRA_BYTES];
    const unsigned bytes = header->record_bytes - header->format->bytes;
    if (bytes == 0)
        return STP_OK;
    STP_TRY(stp_las_text_add(text, err, ", extra bytes (%u a point", bytes));
    const char *before = ": ";
    for (size_t at = 0; at + EXTRA_RECORD_BYTES <= record->length; at += EXTRA_RECORD_BYTES) {
        STP_TRY(stp_las_text_add(text, err, "%s", before));
        STP_TRY(stp_las_text_add_bytes(text, record->bytes + at + AT_EXTRA_NAME, EXTRA_NAME_BYTES,
                                       err));
        stp_las_text_trim(text);
        before = ", ";
    }
    STP_TRY(stp_las_text_add(text, err, ")"));
done:
    return status;
}

static stp_status left_out(stp_las_text *text, const stp_las_header *header,
                           const stp_las_records *records, const stp_las_depth *depth,
                           stp_error *err)
{
    stp_status status = STP_OK;
    const stp_las_format *format = header->format;
    STP_TRY(stp_las_text_add(text, err, "%s",
                             "return number, number of returns, scan direction flag, edge of "
                             "flight line, synthetic, key-point, "));
    STP_TRY(stp_las_text_add(text, err, "%s",
                             format->extended ? "overlap, scanner channel, scan angle"
                                              : "scan angle rank"));
    STP_TRY(stp_las_text_add(text, err, ", user data, point source ID"));
    if (format->gps_time > 0)
        STP_TRY(stp_las_text_add(text, err, ", GPS time"));
    if (format->rgb > 0 && depth->colour == STP_LAS_COLOUR_NONE && header->point_count > 0)
        STP_TRY(stp_las_text_add(text, err, ", red, green, blue (all %s)",
                                 depth->white ? "white" : "zero"));
    if (format->nir > 0)
        STP_TRY(stp_las_text_add(text, err, ", NIR"));
    if (format->wave > 0)
        STP_TRY(stp_las_text_add(text, err, ", wave packets"));
    STP_TRY(add_extra(text, header, records, err));
done:
    return status;
}

static stp_status counts(stp_las_text *text, const stp_las_header *h, uint64_t file_bytes,
                         stp_error *err)
{
    if (h->count_64 > 0 && h->count_32 > 0 && h->count_64 != h->count_32)
        return stp_las_text_add(text, err,
                                "the 64-bit field says %llu points, the legacy one %llu: %llu "
                                "were read",
                                (unsigned long long)h->count_64, (unsigned long long)h->count_32,
                                (unsigned long long)h->point_count);
    if (h->minor_version >= 4 && h->count_64 == 0 && h->count_32 > 0)
        return stp_las_text_add(text, err,
                                "the 64-bit field says 0 points, the legacy one %llu: those were "
                                "read",
                                (unsigned long long)h->count_32);
    /* Up to version 1.2 nothing may follow the points. In later versions waveforms and records may.
     */
    if (h->minor_version > 2 || h->compressed)
        return STP_OK;
    const uint64_t behind = file_bytes - h->point_offset - h->point_count * h->record_bytes;
    if (behind >= h->record_bytes)
        return stp_las_text_add(text, err,
                                "behind the %llu points that the header counts, %llu bytes follow, "
                                "which were not read",
                                (unsigned long long)h->point_count, (unsigned long long)behind);
    return STP_OK;
}

static stp_status scales(stp_las_text *text, const stp_las_header *h, stp_error *err)
{
    stp_status status = STP_OK;
    for (unsigned axis = 0; axis < 3; axis++)
        if (h->scales_assumed & 1u << axis)
            STP_TRY(stp_las_text_add(text, err, "%sthe header gives %c a scale of 0: %g is assumed",
                                     text->length > 0 ? "; " : "", "xyz"[axis], h -> scale[axis]));
        else if (h->scale[axis] < 0.0)
            STP_TRY(stp_las_text_add(text, err,
                                     "%sthe header gives %c a scale of %g: read as it says, which "
                                     "may mirror the scan",
                                     text->length > 0 ? "; " : "", "xyz"[axis], h -> scale[axis]));
done:
    return status;
}

/* Whether x and y are degrees: nobody gives lengths across finer steps than heights. */
static bool has_degrees(const stp_las_header *h)
{
    const double wide = fmax(fabs(h->scale[0]), fabs(h->scale[1]));
    return wide <= 1e-6 && fabs(h->scale[2]) >= 99.0 * wide && fabs(h->offset[0]) <= 360.0 &&
           fabs(h->offset[1]) <= 90.0;
}

stp_status stp_las_notes_make(stp_las_notes *out, const stp_las_header *header,
                              const stp_las_records *records, const stp_las_depth *depth,
                              bool keeps_numbers, uint64_t file_bytes, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_las_record *wkt = &records->kept[STP_LAS_WKT];
    STP_TRY(stp_las_text_add_bytes(&out->texts[out->count], wkt->bytes, wkt->length, err));
    take(out, "wkt");
    STP_TRY(stp_las_geokeys_text(&out->texts[out->count], records, err));
    take(out, "geokeys");
    if (out->count == 0 && has_degrees(header))
        STP_TRY(stp_las_text_add(&out->texts[out->count], err, "the steps of its lattice say so"));
    take(out, "degrees");
    if (!keeps_numbers)
        STP_TRY(left_out(&out->texts[out->count], header, records, depth, err));
    else if (header->format->wave > 0)
        STP_TRY(stp_las_text_add(&out->texts[out->count], err, "wave packets"));
    take(out, "left_out");
    STP_TRY(stp_las_text_add(&out->texts[out->count], err, "%.17g %.17g %.17g %.17g %.17g %.17g",
                             header->scale[0], header->scale[1], header->scale[2],
                             header->offset[0], header->offset[1], header->offset[2]));
    take(out, "lattice");
    if (header->has_time_offset)
        STP_TRY(stp_las_text_add(&out->texts[out->count], err, "%u", header->time_offset));
    take(out, "gps_time_offset");
    STP_TRY(counts(&out->texts[out->count], header, file_bytes, err));
    take(out, "counts");
    STP_TRY(scales(&out->texts[out->count], header, err));
    take(out, "scales");
done:
    return status;
}

void stp_las_notes_free(stp_las_notes *notes)
{
    for (unsigned i = 0; i < STP_LAS_NOTES_MAX; i++)
        stp_las_text_free(&notes->texts[i]);
    *notes = (stp_las_notes){0};
}
