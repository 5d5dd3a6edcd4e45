/* Reads the points of a compressed LAS file through LASzip's C library, if the build found it. */
#include "formats/scan/las/laz.h"

#ifndef STP_HAVE_LASZIP

stp_status stp_laz_open(stp_laz **out, const char *path, const stp_las_header *header,
                        stp_error *err)
{
    (void)out;
    (void)header;
    return stp_error_set(err, STP_UNSUPPORTED,
                         "%s is compressed LAS (LAZ), and this stipple was built without LASzip: "
                         "install LASzip's library and build stipple again, or unpack the file "
                         "(laszip -i in.laz -o out.las, or pdal translate in.laz out.las)",
                         path);
}

stp_status stp_laz_seek(stp_laz *laz, uint64_t point, stp_error *err)
{
    (void)laz;
    (void)point;
    return stp_error_set(err, STP_UNSUPPORTED, "LAZ: built without LASzip");
}

/* as with LASzip, which writes to them: NOLINTNEXTLINE(readability-non-const-parameter) */
stp_status stp_laz_read(stp_laz *laz, unsigned char *records, size_t count, stp_error *err)
{
    (void)records;
    (void)count;
    return stp_laz_seek(laz, 0, err);
}

void stp_laz_close(stp_laz **laz)
{
    *laz = NULL;
}

#else

#include "base/memory.h"
#include "formats/scan/las/las_bytes.h"

#include <laszip/laszip_api.h>

#include <stdlib.h>
#include <string.h>

struct stp_laz {
    const char *path;
    const stp_las_header *header;
    laszip_POINTER library;
    laszip_point_struct *point; /* the point that was read last; owned by the library */
    bool reading;
    uint64_t next;
};

/* Makes an error from the library's message, up to the end of its line. */
static stp_status failed(const stp_laz *laz, const char *what, stp_error *err)
{
    laszip_CHAR *text = NULL;
    if (laszip_get_error(laz->library, &text) != 0 || !text)
        text = "no reason given";
    return stp_error_set(err, STP_CORRUPT,
                         "%s: LASzip could not %s point %llu of %llu (%.*s): the file was cut or "
                         "damaged; copy or export it again",
                         laz->path, what, (unsigned long long)laz->next,
                         (unsigned long long)laz->header->point_count, (int)strcspn(text, "\r\n"),
                         text);
}

stp_status stp_laz_open(stp_laz **out, const char *path, const stp_las_header *header,
                        stp_error *err)
{
    stp_status status = STP_OK;
    laszip_BOOL compressed = 0;
    stp_laz *laz = NULL;
    STP_TRY(stp_alloc(&laz, 1, sizeof *laz, "LAZ reader", err));
    *laz = (stp_laz){.path = path, .header = header};
    if (laszip_create(&laz->library) != 0) {
        laz->library = NULL;
        status = stp_error_set(err, STP_OUT_OF_MEMORY, "%s: LASzip could not be started", path);
        goto done;
    }
    if (laszip_open_reader(laz->library, path, &compressed) != 0) {
        status = failed(laz, "open the file for", err);
        goto done;
    }
    laz->reading = true;
    if (laszip_get_point_pointer(laz->library, &laz->point) != 0) {
        status = failed(laz, "give a place for", err);
        goto done;
    }
    *out = laz;
    laz = NULL;
done:
    stp_laz_close(&laz);
    return status;
}

stp_status stp_laz_seek(stp_laz *laz, uint64_t point, stp_error *err)
{
    if (point == laz->next)
        return STP_OK;
    laz->next = point;
    if (laszip_seek_point(laz->library, (laszip_I64)point) != 0)
        return failed(laz, "go to", err);
    return STP_OK;
}

static void pack(const stp_laz *laz, unsigned char *record)
{
    const laszip_point_struct *p = laz->point;
    const stp_las_format *format = laz->header->format;
    memset(record, 0, laz->header->record_bytes);
    stp_las_put_u32(record, (uint32_t)p->X);
    stp_las_put_u32(record + 4, (uint32_t)p->Y);
    stp_las_put_u32(record + 8, (uint32_t)p->Z);
    stp_las_put_u16(record + 12, p->intensity);
    if (format->extended) {
        record[15] = (unsigned char)(p->extended_classification_flags | p->withheld_flag << 2);
        record[16] = p->extended_classification;
    } else {
        record[15] = (unsigned char)(p->classification | p->synthetic_flag << 5 |
                                     p->keypoint_flag << 6 | p->withheld_flag << 7);
    }
    for (unsigned k = 0; k < 3 && format->rgb > 0; k++)
        stp_las_put_u16(record + format->rgb + 2 * k, p->rgb[k]);
}

stp_status stp_laz_read(stp_laz *laz, unsigned char *records, size_t count, stp_error *err)
{
    for (size_t i = 0; i < count; i++) {
        if (laszip_read_point(laz->library) != 0)
            return failed(laz, "unpack", err);
        pack(laz, records + i * laz->header->record_bytes);
        laz->next++;
    }
    return STP_OK;
}

void stp_laz_close(stp_laz **laz)
{
    stp_laz *l = *laz;
    if (!l)
        return;
    if (l->reading)
        laszip_close_reader(l->library);
    if (l->library)
        laszip_destroy(l->library);
    free(l);
    *laz = NULL;
}

#endif
