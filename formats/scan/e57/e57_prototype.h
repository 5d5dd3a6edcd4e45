/* The fields of an E57 scan's points, from the elements of its prototype. */
#ifndef STP_FORMATS_SCAN_E57_E57_PROTOTYPE_H
#define STP_FORMATS_SCAN_E57_E57_PROTOTYPE_H

#include "formats/scan/e57/e57_xml.h"

/* Value of an attribute in Expat's list of names and values; NULL if it is not there. */
const char *stp_e57_attribute(const char *const *attributes, const char *name);
/* Number of an attribute, or `otherwise` where it is missing; false if it is none or not finite. */
bool stp_e57_attribute_number(const char *const *attributes, const char *name, double otherwise,
                              double *out);

/* Takes a field for one that has no meaning to us. */
void stp_e57_leave_out(stp_e57_document *document, stp_e57_scan *scan, stp_e57_target target);

/* Adds the field of an element that holds a value: names below the prototype itself (top) may have
 * a meaning. Returns NULL, or what is wrong, as the rest of a sentence. */
const char *stp_e57_prototype_add(stp_e57_document *document, stp_e57_scan *scan, const char *name,
                                  const char *type, const char *const *attributes, bool top);

#endif
