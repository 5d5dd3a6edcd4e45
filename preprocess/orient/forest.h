/* Union-find over numbered points, or pieces of them, with signs: each point's sign relative to its
 * root's.
 *
 * A root is the first point of its piece. Threads: one at a time. */
#ifndef STP_PREPROCESS_ORIENT_FOREST_H
#define STP_PREPROCESS_ORIENT_FOREST_H

#include "base/spill.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct stp_forest {
    uint32_t *parent;
    uint8_t *parity;  /* 1: the sign is opposite to the parent's */
    uint32_t *size;   /* of a root's piece; UINT32_MAX: so many, or more */
    stp_spill *spill; /* where the arrays lie */
} stp_forest;

/* Makes every point its own piece. spill: borrowed, NULL for plain memory. Errors: OUT_OF_MEMORY,
 * IO. */
stp_status stp_forest_create(stp_forest *out, uint32_t count, stp_spill *spill, stp_error *err);
void stp_forest_clear(stp_forest *forest);
/* Returns the point's root. *parity: 1 if its sign is opposite to the root's. The root becomes its
 * parent. */
uint32_t stp_forest_find(stp_forest *forest, uint32_t point, uint8_t *parity);
/* Joins the pieces of a and b; `turned`: the signs of a and b are opposite. Does nothing if they
 * are in one piece already. */
void stp_forest_join(stp_forest *forest, uint32_t a, uint32_t b, bool turned);

#endif
