/* libcurl, loaded when the first address is opened: it needs thirty libraries, and would triple the
 * time of each start of the program. Threads: any. */
#ifndef STP_FORMATS_CHUNK_REMOTE_CURL_LIBRARY_H
#define STP_FORMATS_CHUNK_REMOTE_CURL_LIBRARY_H

#include <curl/curl.h>

/* Each X(NAME) is libcurl's function curl_NAME. */
#define STP_CURL_LIST(X)                                                                           \
    X(global_init)                                                                                 \
    X(easy_init)                                                                                   \
    X(easy_cleanup)                                                                                \
    X(easy_setopt)                                                                                 \
    X(easy_getinfo)                                                                                \
    X(easy_strerror)                                                                               \
    X(slist_append)                                                                                \
    X(slist_free_all)                                                                              \
    X(multi_init)                                                                                  \
    X(multi_cleanup)                                                                               \
    X(multi_add_handle)                                                                            \
    X(multi_remove_handle)                                                                         \
    X(multi_perform)                                                                               \
    X(multi_poll)                                                                                  \
    X(multi_wakeup)                                                                                \
    X(multi_info_read)

typedef struct stp_curl {
#define X(name) __typeof__(curl_##name) *(name);
    STP_CURL_LIST(X)
#undef X
} stp_curl;

/* NULL if libcurl is not installed. It stays loaded. */
const stp_curl *stp_curl_load(void);

#endif
