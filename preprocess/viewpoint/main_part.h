/* Finds the part of a cloud that has the most points, if parts lie so far from each other that they
 * would be specks in a picture of all.
 *
 * A part is voxels with points that touch each other, also by corners. Memory: 5 bytes per voxel.
 * Threads: any. */
#ifndef STP_PREPROCESS_VIEWPOINT_MAIN_PART_H
#define STP_PREPROCESS_VIEWPOINT_MAIN_PART_H

#include "preprocess/viewpoint/free_space.h"

/* A part with this share of the points is nearly all there is: the rest is strays. */
#define STP_MAIN_NEARLY_ALL 0.9

typedef struct stp_main_part {
    stp_dbox box;
    double points, share; /* how many points, and their share */
} stp_main_part;

/* The part that has the most points. Errors: OUT_OF_MEMORY. */
stp_status stp_main_part_find(stp_main_part *out, const stp_space *space, stp_error *err);
/* Whether the part may stand out, as far as voxels tell: `all` reaches 4 times as far. */
bool stp_main_part_is_small(const stp_main_part *part, const stp_dbox *all);
/* Whether the part alone should be shown. It is nearly all there is, and `all` reaches 4 times as
 * far; or it has 256 points and a tenth of all at least, and `all` reaches 40 times as far: it
 * would be a speck. */
bool stp_main_part_stands_out(const stp_main_part *part, const stp_dbox *all);

#endif
