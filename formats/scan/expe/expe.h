/* Reads point sets of surfels that Expe, a program like PointShop, writes
 * ("[Expe/PointSet/Binary/0.1]").
 *
 * Lines name the properties of a surfel and their bytes, then `nofpoints N` and `data`; records
 * follow, little endian. The reader takes `position` (three floats), `normal` (three), `color`
 * (four bytes: red, green, blue, alpha) and `radius` (a float), which is an attribute. Other
 * properties are passed over and named in a note. Threads: one at a time per scan. */
#ifndef STP_FORMATS_SCAN_EXPE_EXPE_H
#define STP_FORMATS_SCAN_EXPE_EXPE_H

#include "formats/scan/scan_reader.h"

extern const stp_scan_reader stp_expe_reader;

#endif
