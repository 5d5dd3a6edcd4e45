/* Union-find over numbered points, or pieces of them, that also keeps signs: each one's against its
 * root's.
 *
 * A root is the first of its piece. Threads: one at a time. */
#ifndef STP_PREPROCESS_ORIENT_FOREST_H
#define STP_PREPROCESS_ORIENT_FOREST_H

#include "base/spill.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct stp_forest {
    uint32_t *parent;
    uint8_t *parity;  /* 1: the sign against the parent's is turned */
    uint32_t *size;   /* of a root's piece */
    stp_spill *spill; /* where they lie */
} stp_forest;

/* Every point alone. spill: borrowed, NULL for plain memory. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_forest_create(stp_forest *out, uint32_t count, stp_spill *spill, stp_error *err);
void stp_forest_clear(stp_forest *forest);
/* The point's root; *parity: its sign against the root's. The root becomes its parent. */
uint32_t stp_forest_find(stp_forest *forest, uint32_t point, uint8_t *parity);
/* Makes one piece of two, in which the signs of a and b differ by `turned`; nothing if they are one
 * already. */
void stp_forest_join(stp_forest *forest, uint32_t a, uint32_t b, bool turned);

#endif
