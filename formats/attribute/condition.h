/* A condition (where.h) whose names are found among what points have: fields that every point may
 * have, and attributes. Threads: any (pure functions). */
#ifndef STP_FORMATS_ATTRIBUTE_CONDITION_H
#define STP_FORMATS_ATTRIBUTE_CONDITION_H

#include "formats/attribute/where.h"

/* What points have besides attributes. Colours are 0 to 255. */
#define STP_FIELD_LIST(X) X(x) X(y) X(z) X(intensity) X(class) X(outlier) X(red) X(green) X(blue)

typedef enum stp_point_field {
#define X(name) STP_FIELD_##name,
    STP_FIELD_LIST(X)
#undef X
        STP_FIELD_COUNT /* no such field */
} stp_point_field;

/* Where the value of a name comes from. */
typedef struct stp_condition_source {
    const stp_attribute *attribute; /* or NULL: */
    stp_point_field field;          /* STP_FIELD_COUNT: the value is missing */
    size_t at;                      /* of the attribute, in a packed point */
} stp_condition_source;

typedef struct stp_condition {
    stp_where where;
    stp_condition_source sources[STP_WHERE_NAMES]; /* by name of the condition */
} stp_condition;

/* Finds the names of a parsed condition; they become the attributes' full names. An attribute goes
 * before the field of the same name, because it has all its bits. fields: a bit for each
 * stp_point_field that the points have. list: borrowed by *out. Errors: INVALID_ARGUMENT (a name
 * that stands for nothing or for several attributes; the message has those there are). */
stp_status stp_condition_make(stp_condition *out, const stp_where *where, uint32_t fields,
                              const stp_attribute_list *list, stp_error *err);
/* Takes attributes of the same names from another list; those that it lacks are missing. NULL: all
 * are. */
void stp_condition_bind(stp_condition *condition, const stp_attribute_list *list);
/* Whether a point fulfils the condition. fields: its values, by stp_point_field. packed: its
 * attributes, as the list has them; NULL if no source is an attribute. */
bool stp_condition_holds(const stp_condition *condition, const double fields[STP_FIELD_COUNT],
                         const uint8_t *packed);

#endif
