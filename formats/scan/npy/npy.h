/* Reads points from arrays that NumPy saved (npy_header.h says which). Fields of records have the
 * meaning of their names (column_name.h); numbers without names that of lines of numbers
 * (text/columns.h). Threads: one at a time per scan. */
#ifndef STP_FORMATS_SCAN_NPY_NPY_H
#define STP_FORMATS_SCAN_NPY_NPY_H

#include "formats/scan/scan_reader.h"

extern const stp_scan_reader stp_npy_reader;

#endif
