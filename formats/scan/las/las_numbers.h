/* The attributes of LAS points beside position, colour, intensity and class: where they lie in a
 * record, for readers and writers.
 *
 * Names are those of the standard, in lower case. Colours and intensities are among them, too, with
 * the file's own numbers. Bits of a byte are attributes of their own. Extra bytes have the names
 * and types of their record; bytes that no record describes are "extra_0" and so on. Wave packets
 * are left out. Threads: any (pure functions). */
#ifndef STP_FORMATS_SCAN_LAS_LAS_NUMBERS_H
#define STP_FORMATS_SCAN_LAS_LAS_NUMBERS_H

#include "formats/attribute/attribute.h"
#include "formats/scan/las/las_depth.h"
#include "formats/scan/las/las_records.h"

/* Where an attribute lies in a record. bits 0: the whole number; else bits of the byte. */
typedef struct stp_las_field {
    uint16_t at;
    uint8_t shift, bits;
} stp_las_field;

typedef struct stp_las_numbers {
    stp_attribute_list list;
    stp_las_field fields[STP_ATTRIBUTES_LIMIT];
} stp_las_numbers;

/* Adds an attribute. NULL: there is no room, or another has this name. */
stp_attribute *stp_las_numbers_add(stp_las_numbers *out, const char *name, stp_attribute_type type,
                                   stp_las_field field, double scale);
/* Says what the samples' 8 bits tell of colours and intensities of 16 bits. */
void stp_las_numbers_relate(stp_las_numbers *out, const stp_las_depth *depth);
/* The attributes of a point format, without extra bytes. Colours if `coloured`. withheld: also the
 * flag of this name. */
void stp_las_numbers_of_format(stp_las_numbers *out, const stp_las_format *format, bool coloured,
                               bool withheld);
/* Those of a file. What the depth makes certain is derived from the sample. */
void stp_las_numbers_of_file(stp_las_numbers *out, const stp_las_header *header,
                             const stp_las_records *records, const stp_las_depth *depth,
                             bool withheld);
/* Packs `count` records of `stride` bytes into points of stp_attribute_list_bytes. */
void stp_las_numbers_pack(const stp_las_numbers *numbers, const unsigned char *records,
                          size_t stride, size_t count, uint8_t *out);
/* Puts a number into a record whose other bits stay as they are. */
void stp_las_field_put(const stp_las_field *field, stp_attribute_type type, uint64_t word,
                       unsigned char *record);

#endif
