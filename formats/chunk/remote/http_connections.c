/* Keeps connections, opens and shares them, and learns how many a server takes. */
#include "formats/chunk/remote/http_connections.h"

#include "base/clock.h"
#include "formats/chunk/remote/http_words.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <time.h>

#define WAIT_SLICE_S 0.1
/* After so many good answers, one more request may be in flight. */
#define CALM_ANSWERS 32u
#define RECEIVE_BUFFER_BYTES 131072L

void stp_http_connections_init(stp_http_connections *all)
{
    pthread_condattr_t clock;
    pthread_mutex_init(&all->mutex, NULL);
    pthread_condattr_init(&clock);
    pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
    pthread_cond_init(&all->freed, &clock);
    pthread_condattr_destroy(&clock);
    all->limit = STP_SOURCE_CONNECTIONS;
}

void stp_http_connections_clear(stp_http_connections *all)
{
    for (unsigned i = 0; all->curl != NULL && i < STP_SOURCE_CONNECTIONS; i++) {
        all->curl->easy_cleanup(all->each[i].easy);
        (void)all->curl->multi_cleanup(all->each[i].multi);
    }
    pthread_cond_destroy(&all->freed);
    pthread_mutex_destroy(&all->mutex);
    free(all->moved);
}

/* ---- one for each request ---- */

/* Whether a read is to end: nothing is read any more, or nobody wants its bytes. */
static bool is_over(const stp_http_transfer *t)
{
    return t->ended(t->ended_context) || !stp_http_transfer_is_wanted(t);
}

static bool set_options(const stp_http_connections *all, CURL *easy)
{
    const char *authorities = getenv("CURL_CA_BUNDLE");
    bool secure = strncasecmp(all->address, "https://", 8) == 0;
    if (authorities == NULL)
        authorities = getenv("SSL_CERT_FILE");
    return all->curl->easy_setopt(easy, CURLOPT_URL, all->address) == CURLE_OK &&
           all->curl->easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https") == CURLE_OK &&
           all->curl->easy_setopt(easy, CURLOPT_REDIR_PROTOCOLS_STR,
                                  secure ? "https" : "http,https") == CURLE_OK &&
           all->curl->easy_setopt(easy, CURLOPT_FOLLOWLOCATION, 1L) == CURLE_OK &&
           all->curl->easy_setopt(easy, CURLOPT_MAXREDIRS, STP_HTTP_REDIRECTIONS_LIMIT) ==
               CURLE_OK &&
           all->curl->easy_setopt(easy, CURLOPT_CONNECTTIMEOUT_MS, (long)all->connect_ms) ==
               CURLE_OK &&
           all->curl->easy_setopt(easy, CURLOPT_SUPPRESS_CONNECT_HEADERS, 1L) == CURLE_OK &&
           all->curl->easy_setopt(easy, CURLOPT_NOSIGNAL, 1L) == CURLE_OK &&
           all->curl->easy_setopt(easy, CURLOPT_QUICK_EXIT, 1L) == CURLE_OK &&
           all->curl->easy_setopt(easy, CURLOPT_BUFFERSIZE, RECEIVE_BUFFER_BYTES) == CURLE_OK &&
           all->curl->easy_setopt(easy, CURLOPT_USERAGENT, "stipple") == CURLE_OK &&
           (authorities == NULL ||
            all->curl->easy_setopt(easy, CURLOPT_CAINFO, authorities) == CURLE_OK);
}

static stp_status connect_handle(const stp_http_connections *all, stp_http_connection *c,
                                 stp_error *err)
{
    CURL *easy = all->curl->easy_init();
    CURLM *multi = all->curl->multi_init();
    if (easy == NULL || multi == NULL || !set_options(all, easy) ||
        all->curl->easy_setopt(easy, CURLOPT_ERRORBUFFER, c->text) != CURLE_OK) {
        all->curl->easy_cleanup(easy);
        (void)all->curl->multi_cleanup(multi);
        return stp_error_set(err, STP_OUT_OF_MEMORY, "%s: no memory for a connection", all->name);
    }
    c->curl = all->curl;
    c->easy = easy;
    c->multi = multi;
    return STP_OK;
}

/* Waits for `freed`, at most for a slice of time. The mutex is held. */
static void wait_slice(stp_http_connections *all, double seconds)
{
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_nsec += (long)(seconds * 1e9);
    until.tv_sec += until.tv_nsec / 1000000000L;
    until.tv_nsec %= 1000000000L;
    (void)pthread_cond_timedwait(&all->freed, &all->mutex, &until);
}

/* The mutex is held. */
static unsigned count_busy(const stp_http_connections *all)
{
    unsigned busy = 0;
    for (unsigned i = 0; i < STP_SOURCE_CONNECTIONS; i++)
        busy += all->each[i].busy;
    return busy;
}

/* The first free connection, one that the server has open if there is any: NULL if no more requests
 * may be in flight. The mutex is held. */
static stp_http_connection *find_free(stp_http_connections *all)
{
    stp_http_connection *found = NULL;
    for (unsigned i = 0; i < STP_SOURCE_CONNECTIONS; i++) {
        stp_http_connection *c = &all->each[i];
        if (!c->busy && (found == NULL || (c->answered && !found->answered)))
            found = c;
    }
    return count_busy(all) < all->limit ? found : NULL;
}

stp_status stp_http_acquire(stp_http_connections *all, const stp_http_transfer *t,
                            stp_http_connection **out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_http_connection *c = NULL;
    pthread_mutex_lock(&all->mutex);
    while (c == NULL && !is_over(t)) {
        c = find_free(all);
        if (c == NULL)
            wait_slice(all, WAIT_SLICE_S);
    }
    if (c != NULL && c->easy == NULL)
        status = connect_handle(all, c, err);
    if (c != NULL && status == STP_OK)
        c->busy = true;
    pthread_mutex_unlock(&all->mutex);
    *out = c;
    return status;
}

/* Whether the server closed the connection without an answer, or took none. */
static bool is_closed(const stp_http_transfer *t)
{
    const CURLcode code = t->result;
    return t->verdict == STP_HTTP_NONE &&
           (code == CURLE_COULDNT_CONNECT || code == CURLE_SSL_CONNECT_ERROR ||
            code == CURLE_SEND_ERROR || code == CURLE_RECV_ERROR || code == CURLE_GOT_NOTHING);
}

/* The server takes at most so many requests at a time. True if there were more. */
static bool lower_limit(stp_http_connections *all, unsigned most)
{
    const bool lower = most > 0 && most < all->limit;
    all->limit = lower ? most : all->limit;
    all->calm = 0;
    return lower;
}

/* Learns how many requests the server takes at a time: no more than the others if it refuses one of
 * several, no more than the connections it may have open if it closes one; one more after some good
 * answers. The mutex is held. */
static void learn_limit(stp_http_connections *all, stp_http_transfer *t)
{
    unsigned open = 0;
    for (unsigned i = 0; i < STP_SOURCE_CONNECTIONS; i++)
        open += all->each[i].busy || all->each[i].answered;
    if (t->verdict == STP_HTTP_REFUSED && (t->answer.code == 429 || t->answer.code == 503))
        (void)lower_limit(all, count_busy(all));
    else if (is_closed(t))
        t->crowded = lower_limit(all, open);
    else if (t->verdict == STP_HTTP_GOOD && ++all->calm == CALM_ANSWERS) {
        all->limit += all->limit < STP_SOURCE_CONNECTIONS;
        all->calm = 0;
    }
}

void stp_http_release(stp_http_connections *all, stp_http_connection *c, stp_http_transfer *t)
{
    pthread_mutex_lock(&all->mutex);
    c->busy = false;
    c->answered = t->result == CURLE_OK;
    learn_limit(all, t);
    pthread_cond_signal(&all->freed);
    pthread_mutex_unlock(&all->mutex);
}

/* ---- waiting ---- */

void stp_http_pause(stp_http_connections *all, const stp_http_transfer *t, double seconds)
{
    const double until_s = stp_clock_seconds() + seconds;
    pthread_mutex_lock(&all->mutex);
    for (double left_s = seconds; left_s > 0.0 && !is_over(t);
         left_s = until_s - stp_clock_seconds())
        wait_slice(all, left_s < WAIT_SLICE_S ? left_s : WAIT_SLICE_S);
    pthread_mutex_unlock(&all->mutex);
}

void stp_http_wake(stp_http_connections *all)
{
    pthread_mutex_lock(&all->mutex);
    pthread_cond_broadcast(&all->freed);
    for (unsigned i = 0; i < STP_SOURCE_CONNECTIONS; i++)
        if (all->each[i].multi != NULL)
            (void)all->curl->multi_wakeup(all->each[i].multi);
    pthread_mutex_unlock(&all->mutex);
}

/* ---- redirections ---- */

bool stp_http_choose_address(stp_http_connections *all, stp_http_connection *c)
{
    pthread_mutex_lock(&all->mutex);
    bool moved = all->moved != NULL;
    CURLcode set = c->curl->easy_setopt(c->easy, CURLOPT_URL, moved ? all->moved : all->address);
    pthread_mutex_unlock(&all->mutex);
    return moved && set == CURLE_OK;
}

void stp_http_remember_address(stp_http_connections *all, const stp_http_connection *c)
{
    long count = 0;
    const char *url = NULL;
    if (c->curl->easy_getinfo(c->easy, CURLINFO_REDIRECT_COUNT, &count) != CURLE_OK || count == 0 ||
        c->curl->easy_getinfo(c->easy, CURLINFO_EFFECTIVE_URL, &url) != CURLE_OK || url == NULL)
        return;
    pthread_mutex_lock(&all->mutex);
    if (all->moved == NULL)
        all->moved = strdup(url);
    pthread_mutex_unlock(&all->mutex);
}

void stp_http_forget_address(stp_http_connections *all)
{
    pthread_mutex_lock(&all->mutex);
    free(all->moved);
    all->moved = NULL;
    pthread_mutex_unlock(&all->mutex);
}
