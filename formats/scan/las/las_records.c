/* Reads the variable length records of a LAS file. */
#include "formats/scan/las/las_records.h"

#include "base/memory.h"
#include "formats/scan/las/las_bytes.h"

#include <stdlib.h>
#include <string.h>

#define VLR_HEADER_BYTES 54u
#define EVLR_HEADER_BYTES 60u
#define USER_ID_BYTES 16u

/* A run of records of one kind: VLRs or EVLRs. */
typedef struct record_run {
    bool extended;
    uint32_t count;
    uint64_t begin, end; /* where records may lie */
} record_run;

/* The kind of a record, by user id and record id; STP_LAS_RECORD_KIND_COUNT: not used. */
static stp_las_record_kind kind_of(const unsigned char *header)
{
    static const struct {
        const char *user;
        uint16_t id;
    } known[STP_LAS_RECORD_KIND_COUNT] = {
        [STP_LAS_WKT] = {"LASF_Projection", 2112},
        [STP_LAS_GEO_KEYS] = {"LASF_Projection", 34735},
        [STP_LAS_GEO_DOUBLES] = {"LASF_Projection", 34736},
        [STP_LAS_GEO_ASCII] = {"LASF_Projection", 34737},
        [STP_LAS_EXTRA_BYTES] = {"LASF_Spec", 4},
        [STP_LAS_LASZIP] = {"laszip encoded", 22204},
        [STP_LAS_COPC] = {"copc", 1},
    };
    unsigned kind = 0;
    while (kind < STP_LAS_RECORD_KIND_COUNT &&
           (strncmp((const char *)header + 2, known[kind].user, USER_ID_BYTES) != 0 ||
            stp_las_u16(header + 18) != known[kind].id))
        kind++;
    return (stp_las_record_kind)kind;
}

static stp_status outside(const stp_source *s, const record_run *run, uint32_t index,
                          const char *what, uint64_t needed, stp_error *err)
{
    return stp_error_set(
        err, STP_CORRUPT,
        "%s: byte %llu: %s of %svariable length record %u of %u needs %llu bytes, "
        "but there are %llu until byte %llu, the %s: the file is damaged; copy or "
        "export it again",
        s->path, (unsigned long long)s->offset, what, run->extended ? "extended " : "", index + 1,
        run->count, (unsigned long long)needed, (unsigned long long)(run->end - s->offset),
        (unsigned long long)run->end, run->extended ? "file's end" : "points' begin");
}

static stp_status keep(stp_las_record *record, stp_source *source, uint64_t length, stp_error *err)
{
    stp_status status = STP_OK;
    unsigned char *copy = NULL;
    const unsigned char *bytes;
    size_t available;
    if (length > STP_LAS_RECORD_MAX)
        return stp_error_set(err, STP_LIMIT,
                             "%s: byte %llu: a record of %llu bytes for coordinate system or extra "
                             "bytes, and at most %zu are read: is the file damaged? Export it "
                             "again",
                             source->path, (unsigned long long)source->offset,
                             (unsigned long long)length, STP_LAS_RECORD_MAX);
    STP_TRY(stp_source_peek(source, (size_t)length, &bytes, &available, err));
    if (available < length)
        return stp_error_set(err, STP_CORRUPT, "%s: ends at byte %llu: it was cut; copy it again",
                             source->path, (unsigned long long)source->size);
    STP_TRY(stp_alloc(&copy, (size_t)length, 1, "a record's bytes", err));
    memcpy(copy, bytes, (size_t)length);
    *record = (stp_las_record){copy, (size_t)length};
done:
    return status;
}

static stp_status read_run(stp_las_records *out, const record_run *run, stp_source *source,
                           stp_error *err)
{
    stp_status status = STP_OK;
    const size_t header_bytes = run->extended ? EVLR_HEADER_BYTES : VLR_HEADER_BYTES;
    stp_source_seek(source, run->begin, 0);
    for (uint32_t i = 0; i < run->count; i++) {
        const unsigned char *bytes;
        size_t available;
        if (run->end - source->offset < header_bytes)
            return outside(source, run, i, "the header", header_bytes, err);
        STP_TRY(stp_source_peek(source, header_bytes, &bytes, &available, err));
        if (available < header_bytes)
            return outside(source, run, i, "the header", header_bytes, err);
        const uint64_t length =
            run->extended ? stp_las_u64(bytes + 20) : (uint64_t)stp_las_u16(bytes + 20);
        const stp_las_record_kind kind = kind_of(bytes);
        stp_source_consume(source, header_bytes);
        if (length > run->end - source->offset)
            return outside(source, run, i, "the content", length, err);
        if (kind != STP_LAS_RECORD_KIND_COUNT && !out->kept[kind].bytes && length > 0)
            STP_TRY(keep(&out->kept[kind], source, length, err));
        stp_source_skip(source, length);
    }
done:
    return status;
}

stp_status stp_las_records_read(stp_las_records *out, const stp_las_header *header,
                                stp_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    const record_run plain = {
        .count = header->vlr_count, .begin = header->header_bytes, .end = header->point_offset};
    const record_run extended = {.extended = true,
                                 .count = header->evlr_count,
                                 .begin = header->evlr_offset,
                                 .end = source->size};
    STP_TRY(read_run(out, &plain, source, err));
    if (header->evlr_count > 0)
        STP_TRY(read_run(out, &extended, source, err));
done:
    return status;
}

void stp_las_records_free(stp_las_records *records)
{
    for (int i = 0; i < STP_LAS_RECORD_KIND_COUNT; i++)
        free(records->kept[i].bytes);
    *records = (stp_las_records){0};
}
