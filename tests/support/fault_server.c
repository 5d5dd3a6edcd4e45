/* Implements the tests' web server: one process accepts, and each connection has its own
 * process. */
#include "tests/support/fault_server.h"

#include <arpa/inet.h>
#include <errno.h>
#include <inttypes.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define REQUEST_LIMIT 8192
#define RANGES_LIMIT 128

typedef struct fault_shared {
    atomic_uint requests, apart, open;
    atomic_uint_fast64_t bytes;
    atomic_bool changed;
    fault_orders orders; /* written while no request is running */
    size_t size;
    uint8_t file[];
} fault_shared;

typedef struct asked_range {
    uint64_t begin, last;
} asked_range;

typedef struct answer {
    fault_shared *shared;
    int socket;
    fault_kind kind;
    uint64_t begin, last; /* the bytes to send */
    bool parts;           /* the body has parts */
    uint8_t *body;
    size_t body_bytes;
} answer;

/* ---- sending ---- */

static bool send_all(const answer *a, const void *data, size_t size)
{
    static const struct timespec trickle = {.tv_nsec = 20000000}, drip = {.tv_sec = 1};
    const struct timespec *pause = a->kind == FAULT_TRICKLE ? &trickle
                                   : a->kind == FAULT_DRIP  ? &drip
                                                            : NULL;
    const uint8_t *bytes = data;
    while (size > 0) {
        ssize_t sent = send(a->socket, bytes, pause ? 1 : size, MSG_NOSIGNAL);
        if (sent <= 0)
            return false;
        bytes += sent;
        size -= (size_t)sent;
        if (pause)
            nanosleep(pause, NULL);
    }
    return true;
}

static bool send_text(const answer *a, const char *text)
{
    return send_all(a, text, strlen(text));
}

static bool send_body(const answer *a, size_t size)
{
    atomic_fetch_add(&a->shared->bytes, size);
    return send_all(a, a->body, size);
}

/* Says nothing until the client has gone. */
static void stall(const answer *a)
{
    char heard;
    while (recv(a->socket, &heard, 1, 0) > 0)
        continue;
}

static void endless_headers(const answer *a)
{
    char line[1024];
    memset(line, 'x', sizeof line);
    line[0] = 'X';
    line[1] = ':';
    line[sizeof line - 2] = '\r';
    line[sizeof line - 1] = '\n';
    (void)send_text(a, "HTTP/1.1 206 Partial Content\r\n");
    while (send_all(a, line, sizeof line))
        continue;
}

static void huge_header(const answer *a)
{
    char part[1024];
    memset(part, 'x', sizeof part);
    bool open = send_text(a, "HTTP/1.1 206 Partial Content\r\nX: ");
    for (int i = 0; i < 1024 && open; i++)
        open = send_all(a, part, sizeof part);
    (void)send_text(a, "\r\n\r\n");
}

static void write_validators(const fault_shared *shared, char *out, size_t room)
{
    const char *version = atomic_load(&shared->changed) ? "2" : "1";
    fault_validator v = shared->orders.validator;
    out[0] = '\0';
    if (v == FAULT_ETAG)
        snprintf(out, room, "ETag: \"v%s\"\r\nLast-Modified: Sun, 0%s Nov 2026 10:00:00 GMT\r\n",
                 version, version);
    else if (v == FAULT_ETAG_WEAK)
        snprintf(out, room, "ETag: W/\"w\"\r\nLast-Modified: Sun, 0%s Nov 2026 10:00:00 GMT\r\n",
                 version);
    else if (v == FAULT_MODIFIED)
        snprintf(out, room, "Last-Modified: Sun, 0%s Nov 2026 10:00:00 GMT\r\n", version);
}

static void write_range(const answer *a, char *out, size_t room)
{
    uint64_t total = a->shared->size + (a->kind == FAULT_TOTAL);
    snprintf(out, room, "Content-Range: bytes %" PRIu64 "-%" PRIu64 "/%" PRIu64 "\r\n", a->begin,
             a->last, total);
    if (a->kind == FAULT_NO_TOTAL)
        snprintf(out, room, "Content-Range: bytes %" PRIu64 "-%" PRIu64 "/*\r\n", a->begin,
                 a->last);
    if (a->parts)
        snprintf(out, room, "Content-Type: multipart/byteranges; boundary=END\r\n");
    if (a->kind == FAULT_RANGE_NONE)
        out[0] = '\0';
    if (a->kind == FAULT_RANGE_JUNK)
        snprintf(out, room, "Content-Range: bytes 99999999999999999999-x/%s\r\n", "*");
}

static void write_length(const answer *a, char *out, size_t room)
{
    size_t length = a->body_bytes;
    if (a->kind == FAULT_LENGTH_LONG)
        length += 1000;
    if (a->kind == FAULT_LENGTH_SHORT)
        length /= 2;
    if (a->kind == FAULT_VAST)
        length = (size_t)1 << 62;
    snprintf(out, room, "Content-Length: %zu\r\n", length);
    if (a->kind == FAULT_BODY_LONG || a->kind == FAULT_BODY_SHORT)
        snprintf(out, room, "Connection: close\r\n");
}

/* Sends a 206 with its body, as far as the fault lets it. Returns false if the connection must be
 * closed. */
static bool send_part(const answer *a)
{
    char validators[200], range[200], length[100], headers[700];
    write_validators(a->shared, validators, sizeof validators);
    write_range(a, range, sizeof range);
    write_length(a, length, sizeof length);
    snprintf(headers, sizeof headers, "HTTP/1.1 206 Partial Content\r\n%s%s%s%s\r\n", validators,
             range, length, a->kind == FAULT_ENCODED ? "Content-Encoding: gzip\r\n" : "");
    if (a->kind == FAULT_STALL_HEADERS) {
        (void)send_all(a, headers, strlen(headers) / 2);
        stall(a);
        return false;
    }
    if (!send_text(a, headers))
        return false;
    if (a->kind == FAULT_VAST) {
        stall(a);
        return false;
    }
    bool half = a->kind == FAULT_STALL_BODY || a->kind == FAULT_CUT_BODY ||
                a->kind == FAULT_LENGTH_SHORT || a->kind == FAULT_BODY_SHORT;
    bool sent = send_body(a, half ? a->body_bytes / 2 : a->body_bytes);
    if (a->kind == FAULT_STALL_BODY)
        stall(a);
    if (a->kind == FAULT_BODY_LONG)
        (void)send_body(a, a->body_bytes);
    return sent && (!half || a->kind == FAULT_LENGTH_SHORT) && a->kind != FAULT_LENGTH_LONG &&
           a->kind != FAULT_BODY_LONG;
}

static bool send_whole(const answer *a)
{
    char validators[200], headers[500];
    write_validators(a->shared, validators, sizeof validators);
    snprintf(headers, sizeof headers, "HTTP/1.1 200 OK\r\n%sContent-Length: %zu\r\n\r\n",
             validators, a->shared->size);
    if (!send_text(a, headers))
        return false;
    for (size_t at = 0; at < a->shared->size; at += 65536) {
        size_t part = a->shared->size - at < 65536 ? a->shared->size - at : 65536;
        if (!send_all(a, a->shared->file + at, part))
            return false;
        atomic_fetch_add(&a->shared->bytes, part);
    }
    return true;
}

static bool send_status(const answer *a)
{
    char headers[300], retry[64] = "";
    const fault_orders *o = &a->shared->orders;
    if (o->retry_after != 0)
        snprintf(retry, sizeof retry, "Retry-After: %d\r\n", o->retry_after);
    snprintf(headers, sizeof headers, "HTTP/1.1 %d Because\r\n%sContent-Length: 5\r\n\r\nsorry",
             o->code, retry);
    return send_text(a, headers);
}

static bool send_away(const answer *a)
{
    const char *to = a->kind == FAULT_MOVED  ? "/moved.stipple"
                     : a->kind == FAULT_LOOP ? "/model.stipple"
                                             : "file:///etc/passwd";
    char headers[200];
    snprintf(headers, sizeof headers,
             "HTTP/1.1 302 Found\r\nLocation: %s\r\nContent-Length: 0\r\n\r\n", to);
    return send_text(a, headers);
}

/* ---- a connection ---- */

/* The file's bytes; a changed file has all its bits flipped. */
static void copy_bytes(const fault_shared *s, uint64_t begin, size_t size, uint8_t *out)
{
    for (size_t i = 0; i < size; i++)
        out[i] = atomic_load(&s->changed) ? (uint8_t)~s->file[begin + i] : s->file[begin + i];
}

static uint8_t *allocate(size_t size)
{
    uint8_t *bytes = malloc(size);
    if (bytes == NULL)
        _exit(1);
    return bytes;
}

/* Chooses the bytes to send. */
static void fill_body(answer *a, uint64_t begin, uint64_t last)
{
    const fault_shared *s = a->shared;
    a->begin = begin + (a->kind == FAULT_RANGE_OTHER);
    a->last = last + (a->kind == FAULT_RANGE_OTHER || a->kind == FAULT_RANGE_LONG);
    if (a->kind == FAULT_RANGE_SHORT)
        a->last = begin + (last - begin) / 2;
    a->last = a->last < s->size ? a->last : s->size - 1;
    a->body_bytes = (size_t)(a->last - a->begin + 1);
    a->body = allocate(a->body_bytes);
    copy_bytes(s, a->begin, a->body_bytes, a->body);
    if (a->kind == FAULT_FLIP)
        a->body[a->body_bytes / 16] ^= 4; /* of a first answer, in the file's header */
}

/* Writes a body of several ranges, each with the fault that one would have. */
static void fill_parts(answer *a, const asked_range *ranges, unsigned count)
{
    static const char end[] = "\r\n--END--\r\n";
    size_t room = sizeof end;
    for (unsigned i = 0; i < count; i++)
        room += (size_t)(ranges[i].last - ranges[i].begin) + 300;
    uint8_t *body = allocate(room), *at = body;
    for (unsigned i = 0; i < count; i++) {
        const asked_range *r = &ranges[a->kind == FAULT_PARTS_BACKWARDS ? count - 1 - i : i];
        char headers[250], text[150];
        fill_body(a, r->begin, r->last);
        write_range(a, text, sizeof text);
        int length =
            snprintf(headers, sizeof headers,
                     "\r\n--END\r\nContent-Type: application/octet-stream\r\n%s\r\n", text);
        memcpy(at, headers, (size_t)length);
        memcpy(at + length, a->body, a->body_bytes);
        at += (size_t)length + a->body_bytes;
        free(a->body);
    }
    memcpy(at, end, sizeof end - 1);
    a->body = body;
    a->body_bytes = (size_t)(at - body) + sizeof end - 1;
    a->parts = true;
}

/* Answers that the requested range does not exist. */
static bool send_past(const answer *a)
{
    char headers[200];
    snprintf(headers, sizeof headers,
             "HTTP/1.1 416 Range Not Satisfiable\r\nContent-Range: bytes */%zu\r\n"
             "Content-Length: 0\r\n\r\n",
             a->shared->size);
    return send_text(a, headers);
}

static bool send_answer(answer *a, const asked_range *ranges, unsigned count)
{
    const bool first = count == 1 || a->kind == FAULT_PARTS_FIRST;
    switch (a->kind) {
    case FAULT_STALL:
        stall(a);
        return false;
    case FAULT_CUT:
        return false;
    case FAULT_GARBAGE:
        (void)send_text(a, "this is no web server\r\n\r\n");
        return false;
    case FAULT_ENDLESS:
        endless_headers(a);
        return false;
    case FAULT_HUGE_HEADER:
        huge_header(a);
        return false;
    case FAULT_STATUS:
        return send_status(a);
    case FAULT_WHOLE:
        return send_whole(a);
    case FAULT_MOVED:
    case FAULT_LOOP:
    case FAULT_ELSEWHERE:
        return send_away(a);
    default:
        break;
    }
    if (a->shared->size == 0 || ranges[0].begin >= a->shared->size)
        return send_past(a);
    if (first || a->kind == FAULT_PARTS_JOINED)
        fill_body(a, ranges[0].begin, ranges[first ? 0 : count - 1].last);
    else
        fill_parts(a, ranges, count);
    bool sent = send_part(a);
    free(a->body);
    return sent;
}

static fault_kind choose_fault(fault_shared *s, const char *request, bool apart)
{
    const fault_orders *o = &s->orders;
    unsigned number = atomic_fetch_add(&s->requests, 1);
    atomic_fetch_add(&s->apart, apart);
    bool asked = (apart || !o->apart) && number >= o->first && number - o->first < o->count &&
                 (o->every == 0 || (number - o->first) % o->every == 0);
    if (asked && o->kind == FAULT_CHANGED)
        atomic_store(&s->changed, true);
    if (o->kind == FAULT_MOVED && strncmp(request, "GET /moved", 10) == 0)
        return FAULT_NONE;
    return asked ? o->kind : FAULT_NONE;
}

/* Reads "Range: bytes=0-99,500-599". Returns the number of ranges; 0: none, or wrong ones. */
static unsigned read_ranges(const char *request, asked_range out[RANGES_LIMIT])
{
    unsigned count = 0;
    const char *at = strstr(request, "Range: bytes=");
    for (at = at != NULL ? strchr(at, '=') : NULL; at != NULL && (*at == '=' || *at == ',');) {
        int length = 0;
        asked_range *r = &out[count];
        if (count == RANGES_LIMIT ||
            sscanf(at + 1, "%" SCNu64 "-%" SCNu64 "%n", &r->begin, &r->last, &length) != 2 ||
            r->last < r->begin)
            return 0;
        at += 1 + length;
        count++;
    }
    return count;
}

static void serve(fault_shared *s, int client)
{
    char request[REQUEST_LIMIT];
    bool open = true;
    int at_once = 1; /* headers and body are sent separately */
    (void)setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &at_once, sizeof at_once);
    while (open) {
        size_t got = 0;
        request[0] = '\0';
        while (strstr(request, "\r\n\r\n") == NULL) {
            ssize_t part = recv(client, request + got, sizeof request - 1 - got, 0);
            if (part <= 0)
                return;
            got += (size_t)part;
            request[got] = '\0';
        }
        asked_range ranges[RANGES_LIMIT];
        const unsigned count = read_ranges(request, ranges);
        answer a = {.shared = s, .socket = client, .kind = choose_fault(s, request, count > 1)};
        if (count == 0)
            return;
        open = send_answer(&a, ranges, count);
    }
}

/* ---- the server ---- */

static void accept_all(fault_shared *s, int listener)
{
    signal(SIGCHLD, SIG_IGN);
    for (;;) {
        int client = accept(listener, NULL, NULL);
        if (client < 0)
            continue;
        if (fork() == 0) {
            prctl(PR_SET_PDEATHSIG, SIGKILL);
            close(listener);
            const unsigned most = s->orders.most;
            if (atomic_fetch_add(&s->open, 1) < most || most == 0)
                serve(s, client);
            close(client);
            atomic_fetch_sub(&s->open, 1);
            _exit(0);
        }
        close(client);
    }
}

static int listen_anywhere(unsigned *port)
{
    struct sockaddr_in at = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t size = sizeof at;
    int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (listener < 0 || bind(listener, (struct sockaddr *)&at, sizeof at) != 0 ||
        listen(listener, 64) != 0 || getsockname(listener, (struct sockaddr *)&at, &size) != 0) {
        if (listener >= 0)
            close(listener);
        return -1;
    }
    *port = ntohs(at.sin_port);
    return listener;
}

bool fault_server_create(fault_server *out, const void *bytes, size_t size)
{
    unsigned port = 0;
    int listener = listen_anywhere(&port);
    *out = (fault_server){.shared_bytes = sizeof(fault_shared) + size};
    out->shared =
        mmap(NULL, out->shared_bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (listener < 0 || out->shared == MAP_FAILED)
        return false;
    (void)setenv("no_proxy", "127.0.0.1", 1); /* overrules the environment */
    out->shared->size = size;
    memcpy(out->shared->file, bytes, size);
    snprintf(out->address, sizeof out->address, "http://127.0.0.1:%u/model.stipple", port);
    out->process = fork();
    if (out->process == 0) {
        setpgid(0, 0);
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        accept_all(out->shared, listener);
    }
    setpgid(out->process, out->process); /* whichever process is first */
    close(listener);
    return out->process > 0;
}

void fault_server_destroy(fault_server *server)
{
    if (server->process > 0) {
        kill(-server->process, SIGKILL); /* includes its connections */
        waitpid(server->process, NULL, 0);
    }
    munmap(server->shared, server->shared_bytes);
    *server = (fault_server){0};
}

void fault_server_order(fault_server *server, const fault_orders *orders)
{
    server->shared->orders = *orders;
    atomic_store(&server->shared->changed, false);
    atomic_store(&server->shared->bytes, 0);
    atomic_store(&server->shared->requests, 0);
    atomic_store(&server->shared->apart, 0);
}

unsigned fault_server_requests(const fault_server *server)
{
    return atomic_load(&server->shared->requests);
}

unsigned fault_server_apart(const fault_server *server)
{
    return atomic_load(&server->shared->apart);
}

uint64_t fault_server_bytes(const fault_server *server)
{
    return atomic_load(&server->shared->bytes);
}
