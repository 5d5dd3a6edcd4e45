/* What a column of points means by its name, in text, PLY and PCD.
 *
 * Names are compared without case, without what follows ( or [, without a leading `scalar_` (as
 * CloudCompare writes it), and without the characters _ - . and space: x (also easting, east, e), y
 * (northing, north, n), z (elevation, height, altitude, h; in German rechtswert, hochwert, hoehe),
 * r g b (red green blue), i (intensity, reflectance, reflectivity, amplitude, gray), nx ny nz
 * (normalx ...), class (classification, label); column_name.c has them all: lon (longitude, long,
 * lng) is x, and lat (latitude) is y. Threads: any. */
#ifndef STP_FORMATS_SCAN_COLUMN_NAME_H
#define STP_FORMATS_SCAN_COLUMN_NAME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum stp_column {
    STP_COLUMN_X,
    STP_COLUMN_Y,
    STP_COLUMN_Z,
    STP_COLUMN_RED,
    STP_COLUMN_GREEN,
    STP_COLUMN_BLUE,
    STP_COLUMN_NX,
    STP_COLUMN_NY,
    STP_COLUMN_NZ,
    STP_COLUMN_INTENSITY,
    STP_COLUMN_CLASS,
    STP_COLUMN_COUNT,
    STP_COLUMN_NONE = STP_COLUMN_COUNT,
    STP_COLUMN_PACKED /* of text: a colour as one number or as #rrggbb */
} stp_column;

#define STP_COLUMN_NO_NAME SIZE_MAX

/* The place of a name in the list of known ones, STP_COLUMN_NO_NAME if it is unknown. If two
 * columns mean the same, the one whose name has the lower place should be read. */
size_t stp_column_find_name(const char *begin, const char *end);
/* name: a place in the list; STP_COLUMN_NONE if it is STP_COLUMN_NO_NAME. */
stp_column stp_column_by_name(size_t name);
/* Whether this is the name of a colour in one piece (rgb, color, hex ...), in text. The names that
 * stp_column_find_name knows go before. */
bool stp_column_is_packed(const char *begin, const char *end);
/* Whether it is the name of a longitude or latitude. */
bool stp_column_is_angle(size_t name);

/* For messages. */
const char *stp_column_name(stp_column column);

#endif
