/* The chunk file (.stipple) as C types: directory entries, decoded chunks, reader and writer.
 *
 * formats/SPEC.md is the byte layout. The reader checks every number against the file's size before
 * using it, and never follows a wrong one; a damaged chunk is an error of that chunk only. Does not
 * cache and does not start threads. Several threads may read a stp_chunk_file at once (reads are
 * positional); the writer belongs to one thread. */
#ifndef STP_FORMATS_CHUNK_CHUNK_FILE_H
#define STP_FORMATS_CHUNK_CHUNK_FILE_H

#include "base/error.h"
#include "formats/attribute/attribute.h"
#include "formats/chunk/byte_source.h"
#include "formats/chunk/sample/sample.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The greatest version that this program knows. Version 1 has no blocks; its greatest minor version
 * is STP_CHUNK_FILE_MINOR_1. */
#define STP_CHUNK_FILE_MAJOR 2
#define STP_CHUNK_FILE_MINOR 1 /* of a file with unused bytes; else a writer says 0 */
#define STP_CHUNK_FILE_MINOR_1 2
/* Limits of version 1. Within the limits of coordinates and of a model's longest side, squares of
 * floats neither overflow nor vanish: pictures of a model scaled by powers of two are the same
 * bytes. */
#define STP_COORDINATE_LIMIT 1e15
#define STP_SIDE_LEAST 1e-15 /* or 0: all points in one place */
#define STP_CHUNK_CHILDREN_LIMIT 64u
#define STP_CHUNK_SAMPLES_LIMIT 65536u /* of one level */
#define STP_CHUNK_PATCHES_LIMIT 65536u /* so that level 3 of a prefix keeps to the same limit */
#define STP_CHUNK_NONE UINT32_MAX
/* Payload segments, coarse to fine: patch headers with levels 3 and 2; level 1; level 0. */
#define STP_SEGMENT_COUNT 3

typedef enum stp_codec {
    STP_CODEC_RAW = 0,   /* samples and patches as they are in memory */
    STP_CODEC_DRACO = 1, /* tables of residuals through Draco's symbol coder: smallest */
    STP_CODEC_ZSTD = 2,  /* byte planes of residuals through zstd: some ten times as fast */
    /* The same three, each block of patches by itself (block.h). Files of version 2 have these. */
    STP_CODEC_RAW_BLOCKS = 3,
    STP_CODEC_DRACO_BLOCKS = 4,
    STP_CODEC_ZSTD_BLOCKS = 5,
    /* In blocks, too: squares as ELEV06 stores its maps, all else as raw. */
    STP_CODEC_PAPER = 6
} stp_codec;

#define STP_CODEC_COUNT 7

static inline bool stp_codec_has_blocks(stp_codec codec)
{
    return codec >= STP_CODEC_RAW_BLOCKS && codec < STP_CODEC_COUNT;
}

/* The codec of a block's parts: the codec of the same name without blocks. PAPER has one name. */
static inline stp_codec stp_codec_of_part(stp_codec codec)
{
    return stp_codec_has_blocks(codec) && codec != STP_CODEC_PAPER
               ? (stp_codec)(codec - STP_CODEC_RAW_BLOCKS)
               : codec;
}

/* The codec of the same name with blocks. */
static inline stp_codec stp_codec_in_blocks(stp_codec codec)
{
    return codec == STP_CODEC_PAPER ? codec
                                    : (stp_codec)(stp_codec_of_part(codec) + STP_CODEC_RAW_BLOCKS);
}

/* What an attribute bit says that the source had, or the file has. The sample's bytes exist in any
 * case. */
enum {
    STP_HAS_COLOUR = 1u << 0,
    STP_HAS_INTENSITY = 1u << 1,
    STP_HAS_CLASS = 1u << 2,
    STP_HAS_OUTLIERS = 1u << 3,  /* outliers were looked for and are marked */
    STP_HAS_LINES = 1u << 4,     /* some patches are strips */
    STP_HAS_TRIANGLES = 1u << 5, /* some patches are triangles */
    STP_HAS_CLOSED = 1u << 6,    /* some samples are closed */
    STP_HAS_FITS = 1u << 7,      /* samples say how their normals were found */
    STP_HAS_ALL = (1u << 8) - 1
};

/* The least minor version of version 1 for a file with these attributes. A file without lines,
 * triangles, closed samples and fits can be read by every reader of version 1. */
static inline uint16_t stp_chunk_file_minor(uint32_t attributes)
{
    if (attributes & (STP_HAS_CLOSED | STP_HAS_FITS))
        return 2;
    return attributes & (STP_HAS_LINES | STP_HAS_TRIANGLES) ? 1 : 0;
}

/* Whether a file of a known major version may hold what this program does not know. */
static inline bool stp_chunk_file_is_newer(uint16_t major, uint16_t minor)
{
    return minor > (major == 1 ? STP_CHUNK_FILE_MINOR_1 : STP_CHUNK_FILE_MINOR);
}

/* Flag of an entry: the chunk is linked, its patches say which patches of the children refine them.
 */
#define STP_CHUNK_LINKED 2u
/* Flag of an entry: all patches are closed. */
#define STP_CHUNK_CLOSED 4u

typedef enum stp_orientation {
    STP_ORIENTATION_UNKNOWN = 0,
    STP_ORIENTATION_FILE = 1,
    STP_ORIENTATION_POSITION = 2, /* from scanner positions */
    STP_ORIENTATION_PROPAGATED = 3,
    STP_ORIENTATION_MIXED = 4 /* known for some samples: see their flags */
} stp_orientation;

/* The name in metadata and info: "unknown", "file", "position", "propagated", "mixed". */
const char *stp_orientation_name(stp_orientation orientation);

/* One chunk as the directory describes it: enough to cull, choose and read it. Floats are relative
 * to the chunk's origin. Index l of the level arrays is the level. Ids are breadth first: the root
 * is 0, and the children of a chunk have consecutive ids. */
typedef struct stp_chunk_entry {
    uint64_t offset;                          /* of the payload in the file */
    uint32_t segment_end[STP_SEGMENT_COUNT];  /* bytes from offset */
    uint64_t segment_hash[STP_SEGMENT_COUNT]; /* xxh3-64 of each segment's bytes */
    uint32_t parent;                          /* STP_CHUNK_NONE for the root */
    uint32_t first_child;                     /* STP_CHUNK_NONE for a leaf */
    uint32_t child_count;
    uint32_t patch_count;
    uint32_t sample_count[STP_LEVEL_COUNT];
    uint8_t codec;
    uint8_t depth;          /* root 0 */
    uint8_t flags;          /* STP_PATCH_TWO_SIDED if any patch is; STP_CHUNK_LINKED, _CLOSED */
    uint64_t points_under;  /* level-0 samples of all leaves under the chunk */
    stp_dvec3 origin;       /* world */
    vec3s box_min, box_max; /* hold the bounds of all patches */
    vec3s cone_axis;
    float cone_angle; /* radians; >= pi: normals in all directions */
    float error[STP_LEVEL_COUNT];
    float tangential_error[STP_LEVEL_COUNT];
    float colour_error[STP_LEVEL_COUNT]; /* 0..255 */
    float radius_min, radius_max;
    /* Of a codec with blocks: the records of its blocks in the file's table, and their xxh3-64. */
    uint32_t first_block, block_count;
    uint64_t blocks_hash;
} stp_chunk_entry;

/* Where the samples of a grid over a plane lie. Heights go along an axis of the chunk. Along axis
 * (axis + 1 + k) % 3, the sample of (column, row) is at across[k][0] + column across[k][1] + row
 * across[k][2] + height (across[k][3] + column across[k][4] + row across[k][5]). The last two are
 * those of a camera's image, whose columns and rows spread with the distance; else 0. Lengths are
 * relative to the chunk's origin. */
typedef struct stp_raster {
    bool level;    /* of a survey: columns go along x, rows along y, and normals are upwards */
    bool stops;    /* slopes of heights stop where the depth jumps (square_slope.h) */
    unsigned axis; /* 0 x, 1 y, 2 z */
    /* Encoding looks for samples of so many columns and rows, from the first ones on; 0: of any. */
    uint32_t first[2], side;
    double across[2][6]; /* unless it is level, all but [k][0] are floats: a block stores them so */
} stp_raster;

/* A patch whose level-0 samples are those of a square of 8 x 8 of a grid, in Morton order. */
typedef struct stp_square {
    uint64_t samples;     /* bit i: the square has sample i in Morton order; none: not a square */
    uint32_t column, row; /* of the square, in squares */
    uint32_t raster;      /* which of the chunk's */
} stp_square;

/* A decoded chunk, or a prefix of one: levels >= finest_level are present. The samples of a level
 * are stored patch by patch. level_begin[l][p] is the first sample of patch p,
 * level_begin[l][patch_count] the level's count. */
typedef struct stp_chunk {
    uint32_t id;
    uint32_t patch_count;
    int finest_level; /* 2, 1 or 0 */
    bool linked;      /* patches have first_below */
    stp_patch *patches;
    uint32_t *level_begin[STP_LEVEL_COUNT];
    stp_sample *samples[STP_LEVEL_COUNT];
    uint32_t *block_ends; /* patches at which blocks end; NULL: not cut. Belongs to the chunk */
    uint32_t block_count;
    bool is_block; /* a block of a chunk, coded by itself */
    /* Of grids of heights. Encoding finds the squares by the rasters; decoding sets both. */
    stp_raster *rasters; /* belongs to the chunk */
    uint32_t raster_count;
    unsigned reach;             /* normals are of planes through (2 reach + 1)^2 samples; 0 to 4 */
    stp_square *squares;        /* by patch; NULL: none. Belongs to the chunk */
    struct stp_square_map *map; /* while a block is encoded: its segments share it. Else NULL */
    void *memory;               /* owns all other arrays */
    size_t memory_bytes;
    size_t memory_capacity; /* of the block of arrays; more if another chunk had it before */
} stp_chunk;

/* Whether a decoded block, or the first block of a decoded chunk, is one of squares. */
static inline bool stp_chunk_is_squares(const stp_chunk *chunk)
{
    return chunk->squares && chunk->squares[0].samples;
}

/* Facts about the whole file. Strings and metadata belong to the stp_chunk_file. */
typedef struct stp_chunk_file_info {
    uint16_t version_major, version_minor;
    uint64_t file_bytes;
    uint64_t point_count;
    uint32_t chunk_count;
    uint32_t depth;      /* of the tree: 1 = the root alone */
    uint32_t attributes; /* STP_HAS_* */
    stp_orientation orientation;
    double lambda; /* radius of a level-0 sample over its local spacing */
    stp_dbox box;  /* world, of all level-0 sample centres */
    const char *metadata_json;
    size_t metadata_bytes;
    uint64_t payloads_begin, payloads_end; /* bytes; sections, then the metadata follow */
    uint64_t block_count;                  /* in the table of blocks */
    /* Of the two copies of the header that a file of version 2 has, one is damaged. */
    bool header_damaged;
    uint32_t header_damaged_at; /* byte where that copy begins */
} stp_chunk_file_info;

typedef struct stp_chunk_file stp_chunk_file;

/* Reads header and first directory page; other pages are read when needed. path may be an address
 * (http:// or https://): then two requests bring them, with half a megabyte of the pages that
 * follow. Errors: NOT_FOUND, IO, FORMAT (not a chunk file), VERSION (newer major), CORRUPT (cut, or
 * a checksum or number is wrong); for an address also UNSUPPORTED, INVALID_ARGUMENT, CANCELLED. */
stp_status stp_chunk_file_open(stp_chunk_file **out, const char *path, stp_error *err);
/* The same with a cache, time-outs and a way to interrupt, for addresses. params may be NULL. */
stp_status stp_chunk_file_open_at(stp_chunk_file **out, const char *path,
                                  const stp_byte_source_params *params, stp_error *err);
void stp_chunk_file_close(stp_chunk_file **file);
const stp_chunk_file_info *stp_chunk_file_get_info(const stp_chunk_file *file);
/* The path, or the address without user, password and query, fit to be printed. */
const char *stp_chunk_file_path(const stp_chunk_file *file);
/* The source that the file is read through: how many reads are worth having in flight, cancelling
 * them, and counts. Belongs to the file. */
stp_byte_source *stp_chunk_file_source(stp_chunk_file *file);

/* One directory entry. Errors: INVALID_ARGUMENT (id), IO, CORRUPT. Thread-safe. */
stp_status stp_chunk_file_entry(stp_chunk_file *file, uint32_t id, stp_chunk_entry *out,
                                stp_error *err);

/* Reads, checks and decodes segments until level finest_level (2, 1 or 0) is there. Free with
 * stp_chunk_destroy. Errors: INVALID_ARGUMENT, IO, CORRUPT, UNSUPPORTED (codec), OUT_OF_MEMORY. */
stp_status stp_chunk_file_read(stp_chunk_file *file, uint32_t id, int finest_level, stp_chunk **out,
                               stp_error *err);
void stp_chunk_destroy(stp_chunk **chunk);

/* How many segments hold the levels down to finest_level (2, 1 or 0). */
static inline int stp_segment_count(int finest_level)
{
    return finest_level >= 2 ? 1 : finest_level == 1 ? 2 : 3;
}

/* Reading in two steps, if you read and decode on different threads, or keep payloads. The first
 * stp_chunk_payload_bytes of a payload are what decoding to a level needs. */
uint32_t stp_chunk_payload_bytes(const stp_chunk_entry *entry, int finest_level);
/* Reads bytes [begin, end) of a chunk's payload. From a server, asks once more for segments that
 * lie whole in this range and fail their checksums. Errors: INVALID_ARGUMENT, IO, CORRUPT,
 * CANCELLED. */
stp_status stp_chunk_file_fetch(stp_chunk_file *file, uint32_t id, uint32_t begin, uint32_t end,
                                uint8_t *out, stp_error *err);
/* Working memory for decoding, to be kept from chunk to chunk: {0} at first, one for each thread.
 * Decoding a chunk takes at most a few megabytes. */
typedef struct stp_chunk_scratch {
    void *memory;
    size_t bytes;
    void *context; /* zstd's context, in this memory; NULL until it is needed */
    void *spare;   /* arrays of a recycled chunk: the next chunk needs no new pages */
    size_t spare_bytes;
    struct stp_shares *shares; /* decoding adds what its bytes hold (shares.h); NULL: nobody asks */
} stp_chunk_scratch;

/* Makes room for `bytes`; the old content is lost. Errors: OUT_OF_MEMORY. */
stp_status stp_chunk_scratch_reserve(stp_chunk_scratch *scratch, size_t bytes, stp_error *err);
void stp_chunk_scratch_free(stp_chunk_scratch *scratch);
/* Destroys a chunk and keeps the memory of its arrays for the next chunk decoded with this scratch.
 */
void stp_chunk_recycle(stp_chunk **chunk, stp_chunk_scratch *scratch);

/* Checks and decodes a payload's first bytes. scratch may be NULL. Errors: INVALID_ARGUMENT,
 * CORRUPT, UNSUPPORTED (codec), OUT_OF_MEMORY. */
stp_status stp_chunk_file_decode(stp_chunk_file *file, uint32_t id, int finest_level,
                                 const uint8_t *payload, stp_chunk_scratch *scratch,
                                 stp_chunk **out, stp_error *err);
/* Widens *box by the stored positions of a chunk's level-0 samples. origin: of the chunk's entry.
 */
void stp_chunk_box(const stp_chunk *chunk, stp_dvec3 origin, stp_dbox *box);

/* Memory of a chunk decoded to finest_level, bytes. */
size_t stp_chunk_memory_bytes(const stp_chunk_entry *entry, int finest_level);

/* ---- writing ---- */

typedef struct stp_chunk_writer stp_chunk_writer;

typedef struct stp_chunk_writer_params {
    bool force;      /* replace an existing file */
    bool shared;     /* other processes write some of the payloads */
    stp_codec codec; /* of the payloads */
    uint32_t attributes;
    stp_orientation orientation;
    double lambda;
    /* Called before the file appears, with the name that it has until then. If check fails, finish
     * returns its failure. NULL: nothing is called. */
    stp_status (*check)(void *context, const char *path, stp_error *err);
    void *check_context;
} stp_chunk_writer_params;

/* The file appears under its name only at finish. Errors: EXISTS, IO, OUT_OF_MEMORY. */
stp_status stp_chunk_writer_create(stp_chunk_writer **out, const char *path,
                                   const stp_chunk_writer_params *params, stp_error *err);

struct stp_output;
/* Changes a file of version 2 without attributes in place: *output is that file, reopened, and the
 * writer takes it over, also on failure. New payloads and the rest follow the file's end; bytes
 * behind that end are dropped. Whatever stops the run, the file is as it was, or as it is to be:
 * all is on the disk before finish writes the older copy of the header, and that before the other
 * copy. `file` and `unused_bytes` are borrowed until finish. params: force and check are not used.
 * *unused_bytes: if finish succeeds, the bytes among the payloads that the changed file does not
 * use. Errors: IO, OUT_OF_MEMORY, INVALID_ARGUMENT (another version, attributes). */
stp_status stp_chunk_writer_extend(stp_chunk_writer **out, struct stp_output **output,
                                   stp_chunk_file *file, const stp_chunk_writer_params *params,
                                   uint64_t *unused_bytes, stp_error *err);
/* Keeps a chunk of the file that is changed: its payload stays where it is. Errors: those of
 * stp_chunk_file_entry, OUT_OF_MEMORY, LIMIT. */
stp_status stp_chunk_writer_keep(stp_chunk_writer *writer, uint32_t id, uint32_t *handle,
                                 stp_error *err);

/* Encodes a chunk (thread-safe, no writer needed). *payload receives the bytes of the segments, one
 * after the other (free with free()). Fills entry's segment_end, segment_hash, codec, patch_count,
 * sample_count, flags, box, cone, errors and radius range from the chunk. The caller fills origin,
 * points_under, tree links. Errors: INVALID_ARGUMENT (patches or level_begin are wrong), LIMIT,
 * OUT_OF_MEMORY, INTERNAL (Draco, zstd). */
stp_status stp_chunk_encode(const stp_chunk *chunk, stp_codec codec, void **payload,
                            stp_chunk_entry *entry, stp_error *err);

/* Appends a payload and keeps the entry under a handle (the order of appending, from 0). The links
 * parent and first_child are handles here; finish turns them into ids. */
stp_status stp_chunk_writer_append(stp_chunk_writer *writer, const void *payload,
                                   const stp_chunk_entry *entry, uint32_t *handle, stp_error *err);
struct stp_bytes;
/* The same with the records of its blocks, which stp_block_records_of makes on any thread. payload
 * NULL: another process writes it. */
stp_status stp_chunk_writer_append_made(stp_chunk_writer *writer, const void *payload,
                                        const struct stp_bytes *records,
                                        const stp_chunk_entry *entry, uint32_t *handle,
                                        stp_error *err);
/* Where the next payload goes: byte *offset of the returned path, until finish. */
const char *stp_chunk_writer_next(const stp_chunk_writer *writer, uint64_t *offset);

/* Appends the numbers of all attributes of a chunk, when all payloads are written. list: the same
 * each time, borrowed until finish. rows: list->count, whose offsets count from the begin of bytes;
 * stp_attribute_numbers_encode makes both. A chunk without a call has no numbers. Errors:
 * INVALID_ARGUMENT (a file of version 1), IO, OUT_OF_MEMORY. */
struct stp_attribute_row;
stp_status stp_chunk_writer_append_numbers(stp_chunk_writer *writer, uint32_t handle,
                                           const stp_attribute_list *list, const void *bytes,
                                           size_t size, const struct stp_attribute_row *rows,
                                           stp_error *err);

/* Numbers the chunks breadth first from `root` (a handle), writes directory, metadata and header,
 * and makes the file appear. children[h] lists the children of handle h in order, child_counts[h]
 * their number. Destroys the writer in any case. Errors: INVALID_ARGUMENT (no tree, or an entry
 * that a reader would refuse), IO, LIMIT, OUT_OF_MEMORY, EXISTS. */
stp_status stp_chunk_writer_finish(stp_chunk_writer **writer, uint32_t root,
                                   const uint32_t *const *children, const uint32_t *child_counts,
                                   const stp_dbox *box, const char *metadata_json,
                                   uint64_t *file_bytes, stp_error *err);
/* Destroys the writer and removes what it wrote. */
void stp_chunk_writer_destroy(stp_chunk_writer **writer);

/* Allocates a chunk with arrays for the given patch count and level counts. Level l has an array if
 * l >= finest_level. All is zero except the counts in level_begin. Errors: OUT_OF_MEMORY. */
stp_status stp_chunk_create(stp_chunk **out, uint32_t patch_count,
                            const uint32_t sample_count[STP_LEVEL_COUNT], int finest_level,
                            stp_error *err);
/* The same with arrays of any content: the caller writes all of them. scratch (not NULL) may have
 * memory to spare. */
stp_status stp_chunk_create_blank(stp_chunk **out, uint32_t patch_count,
                                  const uint32_t sample_count[STP_LEVEL_COUNT], int finest_level,
                                  stp_chunk_scratch *scratch, stp_error *err);

#endif
