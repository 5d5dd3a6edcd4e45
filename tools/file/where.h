/* Conditions on the fields of a point, like: return==1 && (class!=7 || intensity>=200).
 *
 *     condition  = all ("||" all)*
 *     all        = one ("&&" one)*
 *     one        = "!" one | "(" condition ")" | side ("==" "!=" "<" "<=" ">" ">=") side
 *     side       = number | name | "name with any characters"
 *
 * A bare name begins with a letter or _ and holds letters, digits, _, - and the like. A comparison
 * with a missing value, NaN, is false, != too. Threads: any (pure functions). */
#ifndef STP_TOOLS_FILE_WHERE_H
#define STP_TOOLS_FILE_WHERE_H

#include "base/error.h"
#include "formats/attribute/attribute.h"

#include <stdbool.h>

#define WHERE_STEPS 64u
#define WHERE_NAMES 32u

/* A number, or the value of a name. */
typedef struct where_side {
    double number;
    int name; /* -1: the number */
} where_side;

typedef enum where_kind {
    WHERE_EQUAL,
    WHERE_UNEQUAL,
    WHERE_LESS_EQUAL,
    WHERE_GREATER_EQUAL,
    WHERE_LESS,
    WHERE_GREATER,
    WHERE_NOT,
    WHERE_AND,
    WHERE_OR
} where_kind;

/* Steps of a stack machine of truths: a comparison pushes one, NOT turns the last, AND and OR join
 * the last two. */
typedef struct where_step {
    where_kind kind;
    where_side left, right; /* of a comparison */
} where_step;

typedef struct where {
    where_step steps[WHERE_STEPS];
    char names[WHERE_NAMES][STP_ATTRIBUTE_NAME_BYTES]; /* each once */
    unsigned step_count, name_count;
} where;

/* Errors: INVALID_ARGUMENT (what was expected, and where). */
stp_status where_parse(where *out, const char *text, stp_error *err);
/* Whether a point fulfils the condition. values: by name. */
bool where_holds(const where *condition, const double values[WHERE_NAMES]);

#endif
