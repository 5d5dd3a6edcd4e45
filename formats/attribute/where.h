/* Conditions on the fields of a point, like: return==1 && (class!=7 || intensity>=200).
 *
 *     condition  = all ("||" all)*
 *     all        = one ("&&" one)*
 *     one        = "!" one | "(" condition ")" | side ("==" "!=" "<" "<=" ">" ">=") side
 *     side       = number | name | "name with any characters"
 *
 * A bare name begins with a letter or _ and holds letters, digits, _, - and the like. A comparison
 * with a missing value, NaN, is false, != too. Threads: any (pure functions). */
#ifndef STP_FORMATS_ATTRIBUTE_WHERE_H
#define STP_FORMATS_ATTRIBUTE_WHERE_H

#include "base/error.h"
#include "formats/attribute/attribute.h"

#include <stdbool.h>

#define STP_WHERE_STEPS 64u
#define STP_WHERE_NAMES 32u

/* A number, or the value of a name. */
typedef struct stp_where_side {
    double number;
    int name; /* -1: the number */
} stp_where_side;

typedef enum stp_where_kind {
    STP_WHERE_EQUAL,
    STP_WHERE_UNEQUAL,
    STP_WHERE_LESS_EQUAL,
    STP_WHERE_GREATER_EQUAL,
    STP_WHERE_LESS,
    STP_WHERE_GREATER,
    STP_WHERE_NOT,
    STP_WHERE_AND,
    STP_WHERE_OR
} stp_where_kind;

/* Steps of a stack machine of truths: a comparison pushes one, NOT turns the last, AND and OR join
 * the last two. */
typedef struct stp_where_step {
    stp_where_kind kind;
    stp_where_side left, right; /* of a comparison */
} stp_where_step;

typedef struct stp_where {
    stp_where_step steps[STP_WHERE_STEPS];
    char names[STP_WHERE_NAMES][STP_ATTRIBUTE_NAME_BYTES]; /* each once */
    unsigned step_count, name_count;
} stp_where;

/* Errors: INVALID_ARGUMENT (what was expected, and where). */
stp_status stp_where_parse(stp_where *out, const char *text, stp_error *err);
/* Whether a point fulfils the condition. values: by name. */
bool stp_where_holds(const stp_where *condition, const double values[STP_WHERE_NAMES]);

#endif
