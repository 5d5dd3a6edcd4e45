/* Reads the pages of an E57 file. */
#include "formats/scan/e57/e57_pages.h"

#include "base/checked.h"
#include "base/file.h"

#include <string.h>
#include <unistd.h>

#define VERSION_MAJOR 1u

/* Little-endian, as in the file. */
typedef struct file_header {
    char magic[8];
    uint32_t version_major, version_minor;
    uint64_t physical_size, xml_physical, xml_size, page_size;
} file_header;

_Static_assert(sizeof(file_header) == STP_E57_HEADER_BYTES, "no padding");

static uint32_t big_endian(const unsigned char *b)
{
    return (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | b[3];
}

static stp_status check_page(const stp_e57_pages *p, uint64_t index, const unsigned char *page,
                             stp_error *err)
{
    const uint32_t found = stp_crc32c_of(&p->crc, page, STP_E57_PAYLOAD_BYTES);
    const uint32_t expected = big_endian(page + STP_E57_PAYLOAD_BYTES);
    if (found == expected)
        return STP_OK;
    return stp_error_set(err, STP_CORRUPT,
                         "%s: the page at byte %llu has checksum %08x where %08x is stored: the "
                         "file is damaged; copy or export it again",
                         p->path, (unsigned long long)(index * STP_E57_PAGE_BYTES), found,
                         expected);
}

/* Loads pages into the block and checks them, if they are not there yet. */
static stp_status load_pages(stp_e57_pages *p, uint64_t first, uint64_t count, stp_error *err)
{
    stp_status status = STP_OK;
    if (first >= p->block_first && first + count <= p->block_first + p->block_count)
        return STP_OK;
    p->block_count = 0;
    STP_TRY(stp_file_read_at(p->descriptor, p->path, first * STP_E57_PAGE_BYTES, p->block,
                             (size_t)count * STP_E57_PAGE_BYTES, err));
    for (uint64_t i = 0; i < count; i++)
        STP_TRY(check_page(p, first + i, p->block + i * STP_E57_PAGE_BYTES, err));
    p->block_first = first;
    p->block_count = count;
done:
    return status;
}

/* Reads the part that fits into a block. */
static stp_status read_part(stp_e57_pages *p, uint64_t logical, unsigned char *out, size_t part,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t first = logical / STP_E57_PAYLOAD_BYTES;
    const uint64_t last = (logical + part - 1) / STP_E57_PAYLOAD_BYTES;
    size_t skip = (size_t)(logical % STP_E57_PAYLOAD_BYTES);
    STP_TRY(load_pages(p, first, last - first + 1, err));
    const unsigned char *page = p->block + (first - p->block_first) * STP_E57_PAGE_BYTES;
    for (; part > 0; page += STP_E57_PAGE_BYTES, skip = 0) {
        size_t size = STP_E57_PAYLOAD_BYTES - skip;
        size = size < part ? size : part;
        memcpy(out, page + skip, size);
        out += size;
        part -= size;
    }
done:
    return status;
}

stp_status stp_e57_pages_read(stp_e57_pages *p, uint64_t logical, void *out, size_t size,
                              stp_error *err)
{
    stp_status status = STP_OK;
    const size_t most = (STP_E57_BLOCK_PAGES - 1) * STP_E57_PAYLOAD_BYTES;
    unsigned char *to = out;
    if (!stp_range_inside(logical, size, p->size))
        return stp_error_set(err, STP_CORRUPT,
                             "%s: %zu bytes are expected at byte %llu, but the file ends before: "
                             "it was cut or is damaged; copy or export it again",
                             p->path, size, (unsigned long long)stp_e57_physical(logical));
    while (size > 0) {
        const size_t part = size < most ? size : most;
        STP_TRY(read_part(p, logical, to, part, err));
        logical += part;
        to += part;
        size -= part;
    }
done:
    return status;
}

stp_status stp_e57_pages_logical(const stp_e57_pages *p, uint64_t physical, const char *what,
                                 uint64_t *logical, stp_error *err)
{
    const uint64_t page = physical / STP_E57_PAGE_BYTES, at = physical % STP_E57_PAGE_BYTES;
    /* No overflow: a page's payload is less than the page. */
    const uint64_t out = page * STP_E57_PAYLOAD_BYTES + at;
    if (at >= STP_E57_PAYLOAD_BYTES || out >= p->size)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: %s is said to begin at byte %llu, which is %s: the file is "
                             "damaged or was cut; copy or export it again",
                             p->path, what, (unsigned long long)physical,
                             at >= STP_E57_PAYLOAD_BYTES ? "inside a page's checksum"
                                                         : "behind the file's end");
    *logical = out;
    return STP_OK;
}

static stp_status check_sizes(const stp_e57_pages *p, const file_header *h, uint64_t file_size,
                              stp_error *err)
{
    if (h->page_size != STP_E57_PAGE_BYTES)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s has pages of %llu bytes (byte 40), where E57 1.0 has %u: export "
                             "the file again",
                             p->path, (unsigned long long)h->page_size, STP_E57_PAGE_BYTES);
    if (h->physical_size > file_size || h->physical_size % STP_E57_PAGE_BYTES != 0 ||
        h->physical_size == 0)
        return stp_error_set(err, STP_CORRUPT,
                             "%s has %llu bytes, but its header (byte 16) says %llu, in pages of "
                             "%u: the file was cut or is damaged; copy or export it again",
                             p->path, (unsigned long long)file_size,
                             (unsigned long long)h->physical_size, STP_E57_PAGE_BYTES);
    return STP_OK;
}

static stp_status read_header(stp_e57_pages *p, uint64_t file_size, stp_error *err)
{
    stp_status status = STP_OK;
    file_header h;
    if (file_size < STP_E57_PAGE_BYTES)
        return stp_error_set(err, STP_CORRUPT,
                             "%s has %llu bytes, less than one page of an E57 file (%u): the file "
                             "was cut; copy or export it again",
                             p->path, (unsigned long long)file_size, STP_E57_PAGE_BYTES);
    /* Check the version before the page's checksum: another version may have another checksum. */
    STP_TRY(stp_file_read_at(p->descriptor, p->path, 0, &h, sizeof h, err));
    if (memcmp(h.magic, "ASTM-E57", sizeof h.magic) != 0)
        return stp_error_set(err, STP_FORMAT, "%s is no E57 file: it does not begin with ASTM-E57",
                             p->path);
    if (h.version_major != VERSION_MAJOR)
        return stp_error_set(err, STP_VERSION,
                             "%s is of E57 version %u.%u (byte 8), where 1.0 is read: export the "
                             "file again",
                             p->path, h.version_major, h.version_minor);
    STP_TRY(check_sizes(p, &h, file_size, err));
    p->size = h.physical_size / STP_E57_PAGE_BYTES * STP_E57_PAYLOAD_BYTES;
    STP_TRY(stp_e57_pages_read(p, 0, &h, sizeof h, err));
    STP_TRY(
        stp_e57_pages_logical(p, h.xml_physical, "the XML section (byte 24)", &p->xml_begin, err));
    p->xml_size = h.xml_size;
    if (!stp_range_inside(p->xml_begin, p->xml_size, p->size))
        status = stp_error_set(err, STP_CORRUPT,
                               "%s: the XML section of %llu bytes at byte %llu (header, byte 32) "
                               "does not fit into the file: it was cut or is damaged; copy or "
                               "export it again",
                               p->path, (unsigned long long)h.xml_size,
                               (unsigned long long)h.xml_physical);
done:
    return status;
}

stp_status stp_e57_pages_open(stp_e57_pages *p, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t size;
    p->descriptor = -1;
    p->path = path;
    stp_crc32c_init(&p->crc);
    STP_TRY(stp_file_open(path, &p->descriptor, &size, err));
    STP_TRY(read_header(p, size, err));
done:
    return status;
}

void stp_e57_pages_close(stp_e57_pages *p)
{
    if (p->descriptor >= 0)
        close(p->descriptor);
    p->descriptor = -1;
}
