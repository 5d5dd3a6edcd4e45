/* Crumbs: pieces too small to be sheets, which noise and sharp edges leave between the sheets.
 * Threads: one call at a time. */
#ifndef STP_PREPROCESS_ORIENT_CRUMBS_H
#define STP_PREPROCESS_ORIENT_CRUMBS_H

#include "preprocess/orient/sheets.h"

/* Turns each crumb of oriented points whose oriented neighbours disagree with it. The neighbours
 * decide by the sum of log odds that each relation is right. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_crumbs_turn(const stp_sheets *sheets, stp_pool *pool, stp_error *err);

#endif
