/* A chunk file opened for drawing: its directory in memory, and a ball around it.
 * runtime/stipple.h declares what host applications may do with it.
 * Threads: read-only after opening, so any. */
#ifndef STP_RUNTIME_CUT_MODEL_H
#define STP_RUNTIME_CUT_MODEL_H

#include "formats/chunk/block/block.h"
#include "formats/chunk/chunk_file.h"
#include "formats/chunk/outside.h"
#include "runtime/stipple.h"

/* No block. */
#define STP_BLOCK_NONE UINT32_MAX

struct stp_model {
    stp_chunk_file *file;
    const stp_chunk_file_info *info;
    stp_chunk_entry *entries; /* by chunk id */
    stp_block *blocks;        /* of all chunks, chunk by chunk */
    uint32_t *first_block;    /* by chunk id; then the number of blocks */
    stp_ball ball;
    stp_outside outside; /* where closed surfaces are seen from outside */
    stp_camera first;    /* if has_first */
    stp_dvec3 up;        /* y or z if the file says which; otherwise zero */
    double first_aspect; /* width / height of the picture that `first` is for */
    bool has_first;
    bool is_grid;              /* of heights: nothing lies where it has no samples */
    bool holes_grow;           /* then: no disc lies over a missing sample */
    bool is_maps;              /* its squares are those of elevation maps */
    bool is_filled;            /* so are its triangles: they lie between maps */
    struct stp_shown *shown;   /* an attribute in place of intensities (shown.h); NULL: none */
    struct stp_chosen *chosen; /* a condition on what is drawn (chosen.h); NULL: all of it */
};

/* stp_model_open, with parameters for addresses as stp_chunk_file_open_at takes them. */
stp_status stp_model_open_at(stp_model **out, const char *path,
                             const stp_byte_source_params *params, stp_error *err);

#endif
