/* Reads the fields of an E57 scan's points from the elements of its prototype. */
#ifndef STP_FORMATS_SCAN_E57_E57_PROTOTYPE_H
#define STP_FORMATS_SCAN_E57_E57_PROTOTYPE_H

#include "formats/scan/e57/e57_xml.h"

/* Returns the value of an attribute in Expat's list of names and values; NULL if it is missing. */
const char *stp_e57_attribute(const char *const *attributes, const char *name);
/* Gets the number of an attribute, or `otherwise` if it is missing. False if it is no finite
 * number. */
bool stp_e57_attribute_number(const char *const *attributes, const char *name, double otherwise,
                              double *out);

/* Marks a field as not used. */
void stp_e57_leave_out(stp_e57_document *document, stp_e57_scan *scan, stp_e57_target target);

/* Adds the field of an element that holds a value. Only names directly below the prototype (top)
 * may have a meaning or be attributes. The document's extras have room for one more. Returns NULL,
 * or the fault as the rest of a sentence. */
const char *stp_e57_prototype_add(stp_e57_document *document, stp_e57_scan *scan, const char *name,
                                  const char *type, const char *const *attributes, bool top);

#endif
