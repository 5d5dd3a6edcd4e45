/* Lists of attributes: adds one by its name, joins the lists of several sources. Threads: any (pure
 * functions). */
#ifndef STP_FORMATS_ATTRIBUTE_ATTRIBUTE_LIST_H
#define STP_FORMATS_ATTRIBUTE_ATTRIBUTE_LIST_H

#include "formats/attribute/attribute.h"

/* Adds an attribute with scale 1. NULL: the list is full or has the name, or it is no name for an
 * attribute: empty, too long, not of printable ASCII, or x, y or z, which every point has. */
stp_attribute *stp_attribute_list_add(stp_attribute_list *list, const char *name,
                                      stp_attribute_type type);

/* One list for the points of several sources. Starts zeroed. */
typedef struct stp_attribute_union {
    stp_attribute_list list;
    stp_attribute_type plain[STP_ATTRIBUTES_LIMIT]; /* types without room for "missing" */
    bool begun;                                     /* a source was added */
} stp_attribute_union;

/* Adds the attributes of a source. An attribute that a source lacks gets a number for "missing". A
 * type may widen; if scales differ, the numbers become values, of type F64. False: the union would
 * have too many attributes; it then has some of them. */
bool stp_attribute_union_add(stp_attribute_union *all, const stp_attribute_list *source);
/* Some points will have no attributes. */
void stp_attribute_union_lack(stp_attribute_union *all);
/* The word in the union's attribute for a word of a source's attribute of that name. */
uint64_t stp_attribute_union_word(const stp_attribute *to, const stp_attribute *from,
                                  uint64_t word);

#endif
