/* Parses and evaluates conditions on fields. */
#include "formats/attribute/where.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Brackets and exclamation marks within each other. */
#define DEPTH_LIMIT 32u

/* Signs of comparisons, by kind: a longer one before its own beginning. */
static const char *const signs[] = {"==", "!=", "<=", ">=", "<", ">"};
#define SIGN_COUNT (sizeof signs / sizeof *signs)

typedef struct parser {
    stp_where *out;
    const char *text, *at;
    unsigned depth;
    stp_error *err;
} parser;

static stp_status expected(const parser *p, const char *what)
{
    return stp_error_set(p->err, STP_INVALID_ARGUMENT,
                         "--where '%.200s%s': %s is expected %s%.40s%s", p->text,
                         strlen(p->text) > 200 ? "..." : "", what, *p->at ? "at '" : "at the end",
                         p->at, *p->at ? "'" : "");
}

static void skip_spaces(parser *p)
{
    p->at += strspn(p->at, " \t\n");
}

static bool take(parser *p, const char *sign)
{
    const size_t length = strlen(sign);
    skip_spaces(p);
    if (strncmp(p->at, sign, length) != 0)
        return false;
    p->at += length;
    return true;
}

static stp_status add(parser *p, const stp_where_step *step)
{
    if (p->out->step_count == STP_WHERE_STEPS)
        return stp_error_set(p->err, STP_INVALID_ARGUMENT,
                             "--where '%.80s...' is too long: it may have %u parts", p->text,
                             STP_WHERE_STEPS);
    p->out->steps[p->out->step_count++] = *step;
    return STP_OK;
}

static stp_status add_name(parser *p, const char *name, size_t length, stp_where_side *side)
{
    stp_where *w = p->out;
    if (length == 0 || length >= STP_ATTRIBUTE_NAME_BYTES)
        return expected(p, "a name");
    for (side->name = 0; side->name < (int)w->name_count; side->name++)
        if (strlen(w->names[side->name]) == length &&
            strncmp(w->names[side->name], name, length) == 0)
            return STP_OK;
    if (w->name_count == STP_WHERE_NAMES)
        return stp_error_set(p->err, STP_INVALID_ARGUMENT, "--where names more than %u fields",
                             STP_WHERE_NAMES);
    memcpy(w->names[w->name_count], name, length);
    w->names[w->name_count++][length] = '\0';
    return STP_OK;
}

static bool is_in_name(char c)
{
    return isalnum((unsigned char)c) || (c && strchr("_-.:[]", c));
}

static stp_status parse_side(parser *p, stp_where_side *side)
{
    *side = (stp_where_side){.name = -1};
    skip_spaces(p);
    const char *begin = p->at;
    if (*begin == '"') {
        const char *end = strchr(begin + 1, '"');
        if (!end)
            return expected(p, "a name that ends in \"");
        p->at = end + 1;
        return add_name(p, begin + 1, (size_t)(end - begin - 1), side);
    }
    if (isalpha((unsigned char)*begin) || *begin == '_') {
        while (is_in_name(*p->at))
            p->at++;
        return add_name(p, begin, (size_t)(p->at - begin), side);
    }
    char *end = NULL;
    side->number = strtod(begin, &end);
    if (end == begin || !isfinite(side->number))
        return expected(p, "a number or a name");
    p->at = end;
    return STP_OK;
}

static stp_status parse_comparison(parser *p)
{
    stp_where_step step;
    stp_status status = parse_side(p, &step.left);
    if (status != STP_OK)
        return status;
    size_t sign = 0;
    while (sign < SIGN_COUNT && !take(p, signs[sign]))
        sign++;
    if (sign == SIGN_COUNT)
        return expected(p, "one of == != < <= > >=");
    step.kind = (stp_where_kind)sign;
    status = parse_side(p, &step.right);
    return status == STP_OK ? add(p, &step) : status;
}

static stp_status parse_joined(parser *p, stp_where_kind by);

// NOLINTNEXTLINE(misc-no-recursion): DEPTH_LIMIT
static stp_status parse_one(parser *p)
{
    stp_status status;
    if (p->depth == DEPTH_LIMIT)
        return expected(p, "a condition in fewer brackets");
    p->depth++;
    if (take(p, "!")) {
        status = parse_one(p);
        if (status == STP_OK)
            status = add(p, &(stp_where_step){.kind = STP_WHERE_NOT});
    } else if (take(p, "(")) {
        status = parse_joined(p, STP_WHERE_OR);
        if (status == STP_OK && !take(p, ")"))
            status = expected(p, ")");
    } else {
        status = parse_comparison(p);
    }
    p->depth--;
    return status;
}

/* Parts joined by && (AND), or such rows of parts joined by || (OR). */
// NOLINTNEXTLINE(misc-no-recursion): DEPTH_LIMIT
static stp_status parse_joined(parser *p, stp_where_kind by)
{
    const stp_where_step join = {.kind = by};
    stp_status status = by == STP_WHERE_OR ? parse_joined(p, STP_WHERE_AND) : parse_one(p);
    while (status == STP_OK && take(p, by == STP_WHERE_OR ? "||" : "&&")) {
        status = by == STP_WHERE_OR ? parse_joined(p, STP_WHERE_AND) : parse_one(p);
        if (status == STP_OK)
            status = add(p, &join);
    }
    return status;
}

stp_status stp_where_parse(stp_where *out, const char *text, stp_error *err)
{
    parser p = {.out = out, .text = text, .at = text, .err = err};
    out->step_count = out->name_count = 0;
    stp_status status = parse_joined(&p, STP_WHERE_OR);
    skip_spaces(&p);
    return status == STP_OK && *p.at ? expected(&p, "&& or ||") : status;
}

static double value_of(const stp_where_side *side, const double *values)
{
    return side->name < 0 ? side->number : values[side->name];
}

static bool compare(const stp_where_step *step, double a, double b)
{
    switch (step->kind) {
    case STP_WHERE_EQUAL:
        return a == b;
    case STP_WHERE_UNEQUAL:
        return a < b || a > b; /* not of NaN */
    case STP_WHERE_LESS_EQUAL:
        return a <= b;
    case STP_WHERE_GREATER_EQUAL:
        return a >= b;
    case STP_WHERE_LESS:
        return a < b;
    default:
        return a > b;
    }
}

bool stp_where_holds(const stp_where *condition, const double values[STP_WHERE_NAMES])
{
    bool stack[STP_WHERE_STEPS] = {false};
    unsigned top = 0;
    for (unsigned i = 0; i < condition->step_count; i++) {
        const stp_where_step *step = &condition->steps[i];
        if (step->kind == STP_WHERE_NOT) {
            stack[top - 1] = !stack[top - 1];
        } else if (step->kind == STP_WHERE_AND || step->kind == STP_WHERE_OR) {
            top--;
            stack[top - 1] = step->kind == STP_WHERE_AND ? stack[top - 1] && stack[top]
                                                         : stack[top - 1] || stack[top];
        } else {
            stack[top++] =
                compare(step, value_of(&step->left, values), value_of(&step->right, values));
        }
    }
    return stack[0];
}
