/* Finds the format of a scan. */
#include "formats/scan/detect.h"

#include "base/file.h"
#include "base/memory.h"
#include "formats/scan/colmap/colmap.h"
#include "formats/scan/detect_text.h"
#include "formats/scan/detect_unread.h"
#include "formats/scan/grid/raster.h"
#include "formats/scan/kitti/kitti.h"
#include "formats/scan/octree/ept_files.h"
#include "formats/scan/source.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define STP_DETECT_BYTES 65536u
/* The first line of a header is shorter. */
#define CR_LOOK_BYTES 48u
#define STP_SUPPORTED                                                                              \
    "supported are PLY, LAS, LAZ, COPC, EPT, PCD, E57, OBJ, OFF, STL, glTF, XYZ, TXT, CSV, PTS "   \
    "(Expe's, too), PTX, NPY, .bin of KITTI and COLMAP, and heights as TIFF, PNG, EXR, PFM, PGM, " \
    "ESRI ASCII, Surfer, HGT, AL3D or raw squares (.r16, .raw, .r32)"

/* The file's begin. */
typedef struct prefix {
    const char *path, *name;
    char *bytes;
    size_t length;
    uint64_t file_size;
    uint8_t wide; /* bytes were UTF-16 (source.h) */
} prefix;

static bool starts_with(const prefix *p, const char *magic, size_t length)
{
    return p->length >= length && memcmp(p->bytes, magic, length) == 0;
}

static bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/* True if the first word of the first line that is no comment is one of words. */
static bool first_word_is(const prefix *p, const char *const *words, size_t count)
{
    size_t at = 0;
    for (;;) {
        while (at < p->length && is_space(p->bytes[at]))
            at++;
        if (at == p->length || p->bytes[at] != '#')
            break;
        while (at < p->length && p->bytes[at] != '\n')
            at++;
    }
    size_t end = at;
    while (end < p->length && !is_space(p->bytes[end]))
        end++;
    for (size_t i = 0; i < count; i++)
        if (end - at == strlen(words[i]) && memcmp(p->bytes + at, words[i], end - at) == 0)
            return true;
    return false;
}

static bool is_ply(const prefix *p)
{
    return starts_with(p, "ply", 3) && (p->length == 3 || is_space(p->bytes[3]));
}

static bool is_las(const prefix *p)
{
    return starts_with(p, "LASF", 4);
}

/* A PCD file may begin with a comment that is its magic, but need not. */
static bool is_pcd(const prefix *p)
{
    static const char *const words[] = {"VERSION"};
    return starts_with(p, "# .PCD", 6) || first_word_is(p, words, 1);
}

static bool is_e57(const prefix *p)
{
    return starts_with(p, "ASTM-E57", 8);
}

static bool is_expe(const prefix *p)
{
    return starts_with(p, "[Expe/PointSet", 14);
}

static bool is_npy(const prefix *p)
{
    return starts_with(p, "\x93NUMPY", 6);
}

static bool is_off(const prefix *p)
{
    static const char *const words[] = {"OFF",   "COFF", "NOFF",  "CNOFF",
                                        "NCOFF", "4OFF", "STOFF", "nOFF"};
    return first_word_is(p, words, sizeof words / sizeof *words);
}

static bool is_obj(const prefix *p)
{
    static const char *const words[] = {"v", "vn", "vt", "o", "g", "s", "mtllib", "usemtl"};
    return first_word_is(p, words, sizeof words / sizeof *words) &&
           !memchr(p->bytes, '\0', p->length);
}

static bool is_stl_ascii(const prefix *p)
{
    static const char *const words[] = {"solid", "SOLID"};
    return first_word_is(p, words, sizeof words / sizeof *words) &&
           !memchr(p->bytes, '\0', p->length);
}

/* Binary STL has no magic, but its size follows from its count. */
static bool is_stl_binary(const prefix *p)
{
    uint32_t count;
    if (p->length < 84)
        return false;
    memcpy(&count, p->bytes + 80, sizeof count);
    return count > 0 && p->file_size == 84 + 50 * (uint64_t)count;
}

/* The begin of a JSON object. */
static bool is_json(const prefix *p)
{
    size_t at = 0;
    while (at < p->length && is_space(p->bytes[at]))
        at++;
    return at < p->length && p->bytes[at] == '{';
}

/* The ept.json of a set. */
static bool is_ept(const prefix *p)
{
    return is_json(p) && memmem(p->bytes, p->length, "\"dataType\"", 10) != NULL &&
           memmem(p->bytes, p->length, "\"bounds\"", 8) != NULL;
}

/* A .glb or a .gltf, whose name tells, too. */
static bool is_gltf(const prefix *p)
{
    return starts_with(p, "glTF", 4) ||
           (is_json(p) && memmem(p->bytes, p->length, "\"asset\"", 7) != NULL &&
            memmem(p->bytes, p->length, "\"version\"", 9) != NULL);
}

static bool is_grid(const prefix *p)
{
    return stp_raster_may_hold_heights(p->bytes, p->length);
}

static bool detect_by_content(const prefix *p, stp_scan_format *format)
{
    static const struct {
        bool (*is)(const prefix *p);
        stp_scan_format format;
    } tests[] = {
        {is_ply, STP_SCAN_PLY},
        {is_las, STP_SCAN_LAS},
        {is_e57, STP_SCAN_E57},
        {is_ept, STP_SCAN_EPT},
        {is_expe, STP_SCAN_EXPE},
        {is_npy, STP_SCAN_NPY},
        {is_grid, STP_SCAN_GRID},
        {is_pcd, STP_SCAN_PCD},
        {is_stl_binary,
         STP_SCAN_STL_BINARY}, /* before ASCII STL: some binary files begin with `solid` */
        {is_stl_ascii, STP_SCAN_STL_ASCII},
        {is_gltf, STP_SCAN_GLTF},
        {is_off, STP_SCAN_OFF},
        {is_obj, STP_SCAN_OBJ},
    };
    for (size_t i = 0; i < sizeof tests / sizeof *tests; i++) {
        if (tests[i].is(p)) {
            *format = tests[i].format;
            return true;
        }
    }
    return false;
}

/* Whether narrow text has lines of numbers, as its content or its name tell. */
static bool has_numbers(const prefix *p)
{
    stp_scan_format format;
    return stp_detect_text(p->bytes, p->length, &format) ||
           stp_detect_text_name(p->name, p->bytes, p->length, &format);
}

static const char *known_but_unsupported(const prefix *p, const char **advice)
{
    if (p->wide > 0 && !has_numbers(p)) {
        *advice = "save it as UTF-8";
        return "text in UTF-16";
    }
    return stp_unread_content(p->bytes, p->length, p->name, advice);
}

/* What a .bin is by its numbers. */
static bool is_named_bin(const prefix *p, stp_scan_format *format)
{
    const bool colmap = stp_colmap_may_be(p->bytes, p->length, p->file_size);
    *format = colmap ? STP_SCAN_COLMAP : STP_SCAN_KITTI;
    return colmap || stp_kitti_may_be(p->bytes, p->length, p->file_size);
}

/* The name decides for meshes before the content decides for lines of numbers. Reason: an OFF file
 * without its first word is also lines of numbers. */
static bool detect_by_name(const prefix *p, stp_scan_format *format)
{
    if (stp_path_ends_in(p->name, ".obj"))
        *format = STP_SCAN_OBJ;
    else if (stp_path_ends_in(p->name, ".stl"))
        *format = STP_SCAN_STL_BINARY;
    else if (stp_path_ends_in(p->name, ".off"))
        *format = STP_SCAN_OFF;
    else if (stp_path_ends_in(p->name, ".gltf"))
        *format = STP_SCAN_GLTF;
    else if (stp_path_ends_in(p->name, ".ply"))
        *format = STP_SCAN_PLY;
    else if (stp_path_ends_in(p->name, ".pcd"))
        *format = STP_SCAN_PCD;
    else if (stp_ept_is_named(p->name))
        *format = STP_SCAN_EPT;
    else if (stp_raster_is_named(p->path) || stp_raster_is_raw(p->path, p->file_size))
        *format = STP_SCAN_GRID;
    else if (stp_path_ends_in(p->name, ".bin") && is_named_bin(p, format))
        return true;
    else
        return stp_detect_text(p->bytes, p->length, format) ||
               stp_detect_text_name(p->name, p->bytes, p->length, format);
    /* Text formats hold no zero bytes. If there are some, the name is wrong, not the content. */
    return *format == STP_SCAN_STL_BINARY || *format == STP_SCAN_GRID ||
           !memchr(p->bytes, '\0', p->length);
}

static stp_status read_prefix(prefix *p, stp_error *err)
{
    stp_status status = STP_OK;
    int descriptor = -1;
    STP_TRY(stp_file_open(p->path, &descriptor, &p->file_size, err));
    p->length = p->file_size < STP_DETECT_BYTES ? (size_t)p->file_size : STP_DETECT_BYTES;
    STP_TRY(stp_alloc(&p->bytes, p->length, 1, "bytes of a file", err));
    STP_TRY(stp_file_read_at(descriptor, p->path, 0, p->bytes, p->length, err));
    unsigned char *bytes = (unsigned char *)p->bytes;
    size_t mark = 0;
    /* low heights of 16 bits look the same */
    const bool named = stp_raster_is_named(p->path) || stp_raster_is_raw(p->path, p->file_size);
    p->wide = named ? 0 : stp_source_is_wide(bytes, p->length, &mark);
    if (p->wide > 0) {
        p->length = p->length / 2 - mark;
        stp_source_narrow(bytes, bytes + 2 * mark, p->length, p->wide);
    }
done:
    if (descriptor >= 0)
        close(descriptor);
    return status;
}

/* True if the first line ends in CR alone, as on old Macintoshes. The rest may be any bytes after a
 * header. */
static bool ends_lines_in_cr(const prefix *p)
{
    const char *cr = p->length > 0 ? memchr(p->bytes, '\r', p->length) : NULL;
    const char *end = p->bytes + p->length;
    if (!cr || cr + 1 == end || cr[1] == '\n' || cr[1] == '\r')
        return false;
    const size_t begun = (size_t)(cr - p->bytes) + CR_LOOK_BYTES;
    return !memchr(p->bytes, '\n', begun < p->length ? begun : p->length);
}

/* Lines of numbers may begin with a byte order mark; text.h checks their line ends. */
static stp_status check_text(const prefix *p, stp_scan_format format, bool marked, stp_error *err)
{
    static const bool is_numbers[STP_SCAN_FORMAT_COUNT] = {
        [STP_SCAN_XYZ] = true,
        [STP_SCAN_PTS] = true,
        [STP_SCAN_PTX] = true,
    };
    static const bool has_lines[STP_SCAN_FORMAT_COUNT] = {
        [STP_SCAN_PCD] = true,
        [STP_SCAN_OBJ] = true,
        [STP_SCAN_OFF] = true,
        [STP_SCAN_STL_ASCII] = true,
    };
    if (p->wide > 0 && !is_numbers[format])
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s is %s as text in UTF-16, which is not read here: save it as UTF-8",
                             p->path, stp_scan_format_name(format));
    if (marked && !is_numbers[format])
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s begins with a byte order mark (the bytes EF BB BF), which is no "
                             "part of its format: take it off (tail -c +4) or save without it",
                             p->path);
    if (has_lines[format] && ends_lines_in_cr(p))
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: its lines end in CR alone, as on old Macintoshes: give them \\n "
                             "(of text alone: tr '\\r' '\\n') or export it again",
                             p->path);
    return STP_OK;
}

stp_status stp_scan_detect_named(stp_scan_format *out, const char *path, const char *name,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    prefix p = {.path = path, .name = name ? name : path};
    stp_scan_format format;
    STP_TRY(read_prefix(&p, err));
    const char *advice = NULL, *other = known_but_unsupported(&p, &advice);
    const bool marked = starts_with(&p, "\xef\xbb\xbf", 3);
    prefix text = p;
    if (marked) {
        text.bytes += 3;
        text.length -= 3;
    }
    if (p.length == 0)
        status =
            stp_error_set(err, STP_EMPTY, "%s is empty (0 bytes): copy or export it again", path);
    else if (!other && !detect_by_content(&text, &format) && !detect_by_name(&text, &format)) {
        other = stp_unread_name(p.name, &advice);
        if (!other)
            status = stp_error_set(
                err, STP_FORMAT,
                "%s is of no known format, by its first bytes and by its name: " STP_SUPPORTED,
                path);
    } else if (!other)
        status = check_text(&text, format, marked, err);
    if (other)
        status = stp_error_set(err, STP_UNSUPPORTED,
                               "%s is %s, which is not read here: %s; " STP_SUPPORTED, path, other,
                               advice);
    if (status == STP_OK)
        *out = format;
done:
    free(p.bytes);
    return status;
}

stp_status stp_scan_detect(stp_scan_format *out, const char *path, stp_error *err)
{
    return stp_scan_detect_named(out, path, NULL, err);
}

const char *stp_scan_format_name(stp_scan_format format)
{
    static const char *const names[STP_SCAN_FORMAT_COUNT] = {
        [STP_SCAN_PLY] = "PLY",     [STP_SCAN_OBJ] = "OBJ",       [STP_SCAN_OFF] = "OFF",
        [STP_SCAN_GLTF] = "glTF",   [STP_SCAN_STL_ASCII] = "STL", [STP_SCAN_STL_BINARY] = "STL",
        [STP_SCAN_LAS] = "LAS",     [STP_SCAN_PCD] = "PCD",       [STP_SCAN_E57] = "E57",
        [STP_SCAN_XYZ] = "XYZ",     [STP_SCAN_PTS] = "PTS",       [STP_SCAN_PTX] = "PTX",
        [STP_SCAN_GRID] = "grid",   [STP_SCAN_EPT] = "EPT",       [STP_SCAN_EXPE] = "Expe",
        [STP_SCAN_KITTI] = "KITTI", [STP_SCAN_COLMAP] = "COLMAP", [STP_SCAN_NPY] = "NumPy"};
    return names[format];
}
