/* The ways in which a web server is bad: what it does, when that begins, and how often. */
#ifndef STP_TESTS_SERVERS_MODES_H
#define STP_TESTS_SERVERS_MODES_H

#include "tests/support/fault_server.h"

#include <stdio.h>

#define SERVER_MODES_LIMIT 200
#define SERVER_FOR_EVER 1000000u

/* What a run must come to. */
typedef enum server_end {
    SERVER_EITHER = 0, /* well or with a sentence: what the server does is a matter of patience */
    SERVER_WELL,
    SERVER_FAILS
} server_end;

typedef struct server_mode {
    char name[80];
    fault_orders orders;
    server_end end;
} server_mode;

typedef struct server_modes {
    unsigned count;
    server_mode modes[SERVER_MODES_LIMIT];
} server_modes;

/* What a fault comes to if some answers have it, and if all do. (A picture's chunk that was refused
 * is asked for once more; verify takes the first refusal.) */
typedef struct server_fault {
    const char *name;
    fault_kind kind;
    server_end some, all;
    int code, retry_after;
} server_fault;

static const server_fault server_faults[] = {
    {"no answer", FAULT_STALL, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"half the headers", FAULT_STALL_HEADERS, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"half the body, silence", FAULT_STALL_BODY, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"50 bytes a second", FAULT_TRICKLE, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"a byte a second", FAULT_DRIP, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"cut", FAULT_CUT, SERVER_WELL, SERVER_FAILS, 0, 0},
    {"cut in the body", FAULT_CUT_BODY, SERVER_WELL, SERVER_EITHER, 0, 0},
    {"no HTTP", FAULT_GARBAGE, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"endless headers", FAULT_ENDLESS, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"a huge header", FAULT_HUGE_HEADER, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"2^62 bytes promised", FAULT_VAST, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"size unknown", FAULT_NO_TOTAL, SERVER_EITHER, SERVER_EITHER, 0, 0},
    {"no range", FAULT_RANGE_NONE, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"range of junk", FAULT_RANGE_JUNK, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"another range", FAULT_RANGE_OTHER, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"range too long", FAULT_RANGE_LONG, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"half the range", FAULT_RANGE_SHORT, SERVER_EITHER, SERVER_EITHER, 0, 0},
    {"other size", FAULT_TOTAL, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"the whole file", FAULT_WHOLE, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"404", FAULT_STATUS, SERVER_EITHER, SERVER_FAILS, 404, 0},
    {"403", FAULT_STATUS, SERVER_EITHER, SERVER_FAILS, 403, 0},
    {"416", FAULT_STATUS, SERVER_EITHER, SERVER_FAILS, 416, 0},
    {"429, after 1 s", FAULT_STATUS, SERVER_EITHER, SERVER_FAILS, 429, 1},
    {"500", FAULT_STATUS, SERVER_WELL, SERVER_FAILS, 500, 0},
    {"503, after an hour", FAULT_STATUS, SERVER_EITHER, SERVER_FAILS, 503, 3600},
    {"another file", FAULT_CHANGED, SERVER_FAILS, SERVER_FAILS, 0, 0},
    {"a flipped bit", FAULT_FLIP, SERVER_WELL, SERVER_FAILS, 0, 0},
    {"length too long", FAULT_LENGTH_LONG, SERVER_WELL, SERVER_EITHER, 0, 0},
    {"length too short", FAULT_LENGTH_SHORT, SERVER_EITHER, SERVER_EITHER, 0, 0},
    {"body too long", FAULT_BODY_LONG, SERVER_EITHER, SERVER_EITHER, 0, 0},
    {"body too short", FAULT_BODY_SHORT, SERVER_EITHER, SERVER_EITHER, 0, 0},
    {"compressed", FAULT_ENCODED, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"moved", FAULT_MOVED, SERVER_WELL, SERVER_WELL, 0, 0},
    {"moved in a loop", FAULT_LOOP, SERVER_EITHER, SERVER_FAILS, 0, 0},
    {"moved to a local file", FAULT_ELSEWHERE, SERVER_EITHER, SERVER_FAILS, 0, 0},
};

static void server_add(server_modes *to, const server_fault *fault, const char *when,
                       const fault_orders *orders, server_end end)
{
    server_mode *m = &to->modes[to->count++];
    snprintf(m->name, sizeof m->name, "%s, %s", fault->name, when);
    m->orders = *orders;
    m->orders.kind = fault->kind;
    m->orders.code = fault->code;
    m->orders.retry_after = fault->retry_after;
    m->end = end;
}

/* What an opened model's chunks come as: the first two answers are its header and directory. */
static void server_add_fault(server_modes *to, const server_fault *f)
{
    const fault_orders always = {.count = SERVER_FOR_EVER}, once = {.first = 2, .count = 1},
                       later = {.first = 3, .count = SERVER_FOR_EVER},
                       fourth = {.first = 3, .count = SERVER_FOR_EVER, .every = 4};
    server_add(to, f, "always", &always, f->all);
    server_add(to, f, "once after the directory", &once, f->some);
    server_add(to, f, "always after 3 answers", &later, f->all);
    server_add(to, f, "each fourth after 3", &fourth, f->some);
}

/* Servers that say little or nothing of the file's state. */
static void server_add_states(server_modes *to)
{
    static const char *const names[] = {"", "a weak ETag", "Last-Modified alone", "no validator"};
    static const server_fault changed = {"another file", FAULT_CHANGED, 0, 0, 0, 0},
                              flipped = {"a flipped bit", FAULT_FLIP, 0, 0, 0, 0},
                              none = {"no fault", FAULT_NONE, 0, 0, 0, 0};
    for (int v = FAULT_ETAG_WEAK; v <= FAULT_NO_VALIDATOR; v++) {
        const fault_orders later = {.first = 4, .count = SERVER_FOR_EVER, .validator = v},
                           third = {.count = SERVER_FOR_EVER, .every = 3, .validator = v};
        server_add(to, &none, names[v], &later, SERVER_WELL);
        server_add(to, &changed, names[v], &later, SERVER_FAILS);
        server_add(to, &flipped, names[v], &third, SERVER_WELL);
    }
}

static void server_list(server_modes *to)
{
    to->count = 0;
    for (size_t i = 0; i < sizeof server_faults / sizeof *server_faults; i++)
        server_add_fault(to, &server_faults[i]);
    server_add_states(to);
}

#endif
