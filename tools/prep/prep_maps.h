/* Options of prep for elevation maps, and what it reports of them. */
#ifndef STP_TOOLS_PREP_PREP_MAPS_H
#define STP_TOOLS_PREP_PREP_MAPS_H

#include "preprocess/prep.h"
#include "tools/cli/cli.h"

struct cJSON;

/* The cone of maps without --cone, degrees. */
#define PREP_MAPS_CONE 60.0

/* Start with cone 0 and error 0: not given. */
typedef struct prep_maps {
    bool wanted;
    double cone, error;
    int gaps;               /* 1: they are filled */
    int codec;              /* 1: the paper's */
    stp_maps_params params; /* set by prep_maps_check */
} prep_maps;

#define PREP_MAPS_OPTIONS 5

void prep_maps_fill(prep_maps *maps, cli_option out[PREP_MAPS_OPTIONS]);
/* Returns what is wrong with the options, or NULL. */
const char *prep_maps_check(prep_maps *maps);
/* Prints on stderr how many maps there are, and how far points are from them. */
void prep_maps_print(const stp_prep_stats *stats);
/* Adds the same with stable keys. */
void prep_maps_json(struct cJSON *root, const stp_prep_stats *stats);

#endif
