/* The tables of a part as one run of symbols, without frames between them.
 *
 * formats/SPEC.md, "Tight parts", has the layout. Reading treats every byte as hostile: what is cut
 * or changed gives cells of any values, and the end of the run tells. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_ODDS_TIGHT_H
#define STP_FORMATS_CHUNK_CODEC_ODDS_TIGHT_H

#include "formats/chunk/codec/odds/cells.h"
#include "formats/chunk/codec/predict/corners.h"

/* By column of patches: the bits of the mean that its odds begin with, and the sign of its cells.
 * By column of samples: bits of means of level 3, of elder and of last children. They are what
 * blocks of scans have. */
extern const uint8_t stp_tight_patches[], stp_tight_vertices[], stp_tight_elder[], stp_tight_last[];
/* The same of elder and last children of squares: of level 0, and of merged samples. */
extern const uint8_t *const stp_tight_squares[2][2];
extern const int8_t stp_tight_sides[];

/* Tables that are written. Begin as zeros. */
typedef struct stp_tight_writer {
    stp_symbol_writer symbols;
    bool scaled; /* the scale has been told, and the sublattices */
    bool coarse; /* the grids of both tables of the level have been told */
} stp_tight_writer;

/* Takes the next table, which has tight_first; its odds begin as known_odds.h says. A table without
 * rows takes no symbols. All tables that may have a scale have the same. Errors: OUT_OF_MEMORY. */
stp_status stp_tight_put(stp_tight_writer *w, const stp_table *table, stp_error *err);
/* Takes which corners are told, before the tables of level 0. Errors: OUT_OF_MEMORY. */
stp_status stp_tight_put_corners(stp_tight_writer *w, const stp_chunk *block,
                                 const stp_corners *corners, stp_error *err);
void stp_tight_clear(stp_tight_writer *w);

/* Tables that are read. */
typedef struct stp_tight_reader {
    stp_symbol_reader symbols;
    stp_first_odds first; /* unless odds are known, as `how` */
    stp_odds how;         /* of whether columns are constant */
    bool scaled, coarse;  /* as above */
    bool known;
    bool shift_read; /* the shift of the next table has been read: normal_shift */
    unsigned normal_shift, normal_odd, radius_shift;
    stp_scale scale; /* of all tables, once it has been told */
} stp_tight_reader;

/* Whether the bytes of a part begin as a tight part does. No other part of tables does. */
bool stp_is_tight(const uint8_t *bytes, size_t size);
/* Errors: CORRUPT. */
stp_status stp_tight_read(stp_tight_reader *r, const uint8_t *bytes, size_t size, stp_error *err);
/* Reads the next table, whose counts and tight_first the caller has set. Errors: CORRUPT,
 * OUT_OF_MEMORY. */
stp_status stp_tight_get(stp_tight_reader *r, stp_table *table, stp_error *err);
/* Reads which corners are told, if the part says so; `of` stays NULL if not. Errors: CORRUPT,
 * OUT_OF_MEMORY. */
stp_status stp_tight_get_corners(stp_tight_reader *r, const stp_chunk *block, stp_corners *out,
                                 stp_error *err);
/* Checks that all symbols are read and nothing is left. Errors: CORRUPT. */
stp_status stp_tight_end(const stp_tight_reader *r, stp_error *err);

#endif
