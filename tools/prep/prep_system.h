/* The coordinate systems of inputs, and the one that they are brought to.
 *
 * The one system is that of --to, else that of the model that points are added to, else that of the
 * first input that says its own. Longitude and latitude are no lengths: if the first input has
 * them, the system is the zone of UTM in which its first point lies. Inputs of other systems are
 * projected; those that say none stay. An input's system is what the file says, or a .prj file
 * beside it. */
#ifndef STP_TOOLS_PREP_PREP_SYSTEM_H
#define STP_TOOLS_PREP_PREP_SYSTEM_H

#include "formats/scan/geo/projection.h"
#include "formats/scan/scan.h"
#include "preprocess/prep.h"
#include "tools/cli/cli.h"

typedef struct prep_system {
    const char *wanted; /* --to; NULL: none */
    char *target;       /* that of the model or of an input so far; NULL: none is known */
} prep_system;

/* The option --to. */
cli_option prep_system_option(const char **wanted);

/* How an input is projected. */
typedef struct prep_way {
    stp_projection *projection; /* NULL: positions stay */
    bool unknown;               /* positions stay, since PROJ does not know the system */
    bool guessed;               /* x and y look like degrees, and no system is named */
} prep_way;

/* Chooses how the positions of an input are moved. Errors: UNSUPPORTED (no system is told, lines or
 * faces), those of opening and reading the scan and of the projection. Free the projection. */
stp_status prep_system_choose(prep_system *system, const char *path, const stp_scan_params *params,
                              const stp_scan_info *info, prep_way *way, stp_error *err);
/* The path of the .prj file that may be beside a scan. Errors: OUT_OF_MEMORY. Free with free(). */
stp_status prep_system_prj(char **out, const char *path, stp_error *err);
/* Adds a note; both texts are copied. Errors: OUT_OF_MEMORY. */
stp_status prep_system_add_note(stp_prep_file *file, const char *name, const char *text,
                                stp_error *err);
/* Makes the file's notes say where its points are now, and what they came from. Errors:
 * OUT_OF_MEMORY. */
stp_status prep_system_note(stp_prep_file *file, const stp_projection *way, stp_error *err);
/* Adds the note "wkt" of an input whose positions stay, if only GeoTIFF's keys or a .prj file tell
 * its system: the name and the units of the picture, and LAS files made of the model, need it.
 * Errors: OUT_OF_MEMORY, IO (the .prj file). */
stp_status prep_system_tell(stp_prep_file *file, const char *path, const stp_scan_info *info,
                            stp_error *err);
/* Moves points. Their normals are dropped: they were of another space. */
void prep_system_move(stp_projection *way, stp_point *points, size_t count);
/* Finds where the file's raster lies after its samples are moved. If some part of it has no place
 * there, or the raster is torn, the file has no raster any more. Errors: OUT_OF_MEMORY. */
stp_status prep_system_move_raster(stp_prep_file *file, stp_projection *way, stp_error *err);
void prep_system_clear(prep_system *system);

#endif
