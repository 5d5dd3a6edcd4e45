/* Leaves out of a shader what it does not use: comments, and functions that nothing calls. */
#include "runtime/gl/shader_trim.h"

#include <ctype.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#define FUNCTIONS_LIMIT 256u
#define SLOT_COUNT 1024u /* a power of two, several times the limit */

typedef struct function {
    const char *begin, *end; /* from the type to the closing brace */
    const char *name;
    size_t name_length;
    size_t same; /* the function before that has this name, + 1; 0: none */
    bool used;
} function;

typedef struct outline {
    function functions[FUNCTIONS_LIMIT];
    size_t count;
    size_t slots[SLOT_COUNT]; /* by the name's hash: the last function of a name, + 1 */
    size_t waiting[FUNCTIONS_LIMIT], waiting_count; /* used, and not yet searched for names */
} outline;

static bool is_word(char c)
{
    return isalnum((unsigned char)c) || c == '_';
}

/* ---- comments ---- */

/* Removes comments but the line ends in them. */
static void remove_comments(char *text)
{
    char *to = text;
    for (const char *c = text; *c != '\0';) {
        if (c[0] == '/' && c[1] == '/') {
            c += strcspn(c, "\n");
        } else if (c[0] == '/' && c[1] == '*') {
            const char *end = strstr(c + 2, "*/");
            end = end != NULL ? end + 2 : c + strlen(c);
            *to++ = ' ';
            for (; c < end; c++)
                if (*c == '\n')
                    *to++ = '\n';
        } else {
            *to++ = *c++;
        }
    }
    *to = '\0';
}

/* ---- functions ---- */

static size_t slot_of(const outline *o, const char *name, size_t length)
{
    size_t slot = 5381;
    for (size_t i = 0; i < length; i++)
        slot = slot * 33 + (unsigned char)name[i];
    for (slot %= SLOT_COUNT; o->slots[slot] != 0; slot = (slot + 1) % SLOT_COUNT) {
        const function *f = &o->functions[o->slots[slot] - 1];
        if (f->name_length == length && memcmp(f->name, name, length) == 0)
            break;
    }
    return slot;
}

/* The end of the braces that open at `open`; NULL: they do not close. */
static const char *closing_end(const char *open)
{
    size_t depth = 0;
    for (const char *c = open; *c != '\0'; c++) {
        depth += *c == '{';
        if (*c == '}' && --depth == 0)
            return c + 1;
    }
    return NULL;
}

/* Whether as many conditions begin as end. */
static bool conditions_match(const char *begin, const char *end)
{
    int open = 0;
    for (const char *c = begin; c < end; c++) {
        if (*c != '#')
            continue;
        const char *word = c + 1 + strspn(c + 1, " ");
        open += strncmp(word, "if", 2) == 0;
        open -= strncmp(word, "endif", 5) == 0;
    }
    return open == 0;
}

/* Takes what begins at a line's first word as a function: TYPE NAME(...) { ... }. If it is none,
 * returns false. */
static bool parse_function(const char *begin, function *out)
{
    static const char *const others[] = {"layout",  "struct", "const",
                                         "uniform", "buffer", "shared"};
    const char *open = begin + strcspn(begin, "{;=");
    const char *parameters = begin + strcspn(begin, "(");
    if (*open != '{' || parameters > open)
        return false;
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        size_t length = strlen(others[i]);
        if (strncmp(begin, others[i], length) == 0 && !is_word(begin[length]))
            return false;
    }
    const char *name = parameters;
    while (name > begin && is_word(name[-1]))
        name--;
    *out = (function){.begin = begin,
                      .end = closing_end(open),
                      .name = name,
                      .name_length = (size_t)(parameters - name)};
    return name > begin && name < parameters && out->end != NULL &&
           conditions_match(begin, out->end);
}

/* Lists the functions; false: there are too many. */
static bool list_functions(outline *o, const char *text)
{
    for (const char *line = text; *line != '\0'; line += line[0] == '\n') {
        function f;
        if ((isalpha((unsigned char)*line) || *line == '_') && parse_function(line, &f)) {
            if (o->count == FUNCTIONS_LIMIT)
                return false;
            size_t *slot = &o->slots[slot_of(o, f.name, f.name_length)];
            f.same = *slot;
            o->functions[o->count++] = f;
            *slot = o->count;
            line = f.end;
        }
        line += strcspn(line, "\n");
    }
    return true;
}

/* ---- what is used ---- */

static void use(outline *o, const char *name, size_t length)
{
    for (size_t i = o->slots[slot_of(o, name, length)]; i != 0; i = o->functions[i - 1].same) {
        if (o->functions[i - 1].used)
            return;
        o->functions[i - 1].used = true;
        o->waiting[o->waiting_count++] = i - 1;
    }
}

/* Uses all functions that a part of the text names. */
static void use_names(outline *o, const char *begin, const char *end)
{
    for (const char *c = begin; c < end;) {
        const char *word = c;
        while (c < end && is_word(*c))
            c++;
        if (c > word && !isdigit((unsigned char)*word))
            use(o, word, (size_t)(c - word));
        c += c == word;
    }
}

static void find_used(outline *o, const char *text)
{
    const char *at = text;
    for (size_t i = 0; i < o->count; i++) {
        use_names(o, at, o->functions[i].begin);
        at = o->functions[i].end;
    }
    use_names(o, at, at + strlen(at));
    use(o, "main", 4);
    while (o->waiting_count > 0) {
        const function *f = &o->functions[o->waiting[--o->waiting_count]];
        use_names(o, f->begin, f->end);
    }
}

void stp_shader_trim(char *text)
{
    outline o = {.count = 0};
    char *to = text;
    remove_comments(text);
    if (!list_functions(&o, text))
        return;
    find_used(&o, text);
    const char *from = text;
    for (size_t i = 0; i < o.count; i++) {
        const function *f = &o.functions[i];
        const char *kept = f->used ? f->end : f->begin;
        memmove(to, from, (size_t)(kept - from));
        to += kept - from;
        for (from = kept; from < f->end; from++)
            if (*from == '\n')
                *to++ = '\n';
    }
    memmove(to, from, strlen(from) + 1);
}
