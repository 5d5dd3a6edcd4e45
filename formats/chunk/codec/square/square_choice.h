/* What the writer of a level of squares chooses: the bytes before its tables. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_SQUARE_CHOICE_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_SQUARE_CHOICE_H

#include "formats/chunk/codec/square/square_map.h"
#include "formats/chunk/codec/table/column.h"
#include "formats/chunk/codec/table/table.h"

typedef struct stp_square_choice {
    unsigned reach;  /* of the windows of normals, 1 to 4; 0, 5 to 7: square.h */
    bool follow;     /* red and blue change as green does */
    bool loose;      /* colours do not follow from what is left of the parent's */
    bool rows;       /* of level 0, tight: colours are coded by rows (square_colours.h) */
    bool by_parents; /* likewise: the parents around tell, too */
    bool tight;      /* the tables that follow are one run (tight.h) */
    bool sides;      /* of normals that two codes tell, the lesser one is meant (square_normal.h) */
    unsigned steps;  /* of levels 1 and 2: heights are multiples of 2^steps */
    unsigned radii;  /* codes of radii are 1 + multiples of 2^radii */
    uint32_t rungs;  /* of the ladder, whose table comes first (ladder.h); 0: there is none */
} stp_square_choice;

/* Sets `steps`, `sides` and `radii` of a tight level. normal_shift: of its normals' grid. */
void stp_square_choice_find(const stp_chunk *block, int level, const stp_square_map *map,
                            unsigned normal_shift, stp_square_choice *choice);
/* Appends the bytes. Errors: OUT_OF_MEMORY. */
stp_status stp_square_choice_write(const stp_square_choice *choice, stp_bytes *out, stp_error *err);
bool stp_square_choice_is_tight(uint8_t first_byte);
/* tight: what the part is. Errors: CORRUPT. */
stp_status stp_square_choice_read(stp_cursor *c, int level, bool tight, stp_square_choice *out,
                                  stp_error *err);

/* Whether red and blue of elder children take less if they change as green does. */
bool stp_square_colours_follow(const stp_table *elder);
/* Takes green off red and blue of elder children (sign -1), or adds it (1). */
void stp_square_colours_move(const stp_table *table, int sign);

#endif
