/* Finds the format of a scan from its first bytes or, if they do not decide, from its name. */
#ifndef STP_FORMATS_SCAN_DETECT_H
#define STP_FORMATS_SCAN_DETECT_H

#include "base/error.h"

typedef enum stp_scan_format {
    STP_SCAN_PLY,
    STP_SCAN_OBJ,
    STP_SCAN_OFF,
    STP_SCAN_GLTF,
    STP_SCAN_STL_ASCII,
    STP_SCAN_STL_BINARY,
    STP_SCAN_LAS, /* LAZ and COPC too */
    STP_SCAN_EPT, /* its ept.json */
    STP_SCAN_PCD,
    STP_SCAN_E57,
    STP_SCAN_XYZ,
    STP_SCAN_PTS,
    STP_SCAN_PTX,
    STP_SCAN_EXPE,   /* surfels, in a file that ends in .pts, too */
    STP_SCAN_KITTI,  /* turns of a lidar in floats, .bin */
    STP_SCAN_COLMAP, /* points3D.bin */
    STP_SCAN_NPY,    /* arrays of NumPy */
    STP_SCAN_GRID, /* of heights or depths: TIFF, PNG, EXR, PFM, PGM, ESRI ASCII, Surfer, HGT, AL3D
                    */
    STP_SCAN_FORMAT_COUNT
} stp_scan_format;

/* Errors: NOT_FOUND, IO, EMPTY (no bytes), UNSUPPORTED (a known format that is not read here),
 * FORMAT (an unknown format). */
stp_status stp_scan_detect(stp_scan_format *out, const char *path, stp_error *err);

/* The same for a file that has another name than its path; NULL: the path. */
stp_status stp_scan_detect_named(stp_scan_format *out, const char *path, const char *name,
                                 stp_error *err);

/* "PLY", "STL". */
const char *stp_scan_format_name(stp_scan_format format);

#endif
