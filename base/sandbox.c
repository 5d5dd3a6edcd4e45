/* Landlock: a ruleset denies groups of rights, and rules allow exceptions. */
#include "base/sandbox.h"

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#ifdef SYS_landlock_create_ruleset

/* The kernel's interface (landlock(7)). Older headers know only its first fields. */
typedef struct ruleset {
    uint64_t files, net, scoped;
} ruleset;

typedef struct __attribute__((packed)) path_rule {
    uint64_t allowed;
    int32_t parent;
} path_rule;

enum {
    ASK_VERSION = 1,
    RULE_PATH = 1,
    WRITE_FILE = 1 << 1,
    READ_FILE = 1 << 2,
    READ_FOLDER = 1 << 3,
    REMOVE_FILE = 1 << 5,
    MAKE_FILE = 1 << 8,
    TRUNCATE = 1 << 14, /* version 3 */
    OF_FILES = 1 << 0 | WRITE_FILE | READ_FILE | TRUNCATE | 1 << 15,
    OF_NET = 3,   /* bind and connect TCP, version 4 */
    OF_SCOPES = 3 /* abstract sockets of others, signals to others; version 6 */
};
/* All rights on files and folders in versions 1, 2, 3, 4 and 5. */
static const uint64_t file_rights[] = {(1u << 13) - 1, (1u << 14) - 1, (1u << 15) - 1,
                                       (1u << 15) - 1, (1u << 16) - 1};

static int create_ruleset(const ruleset *rules, size_t bytes, unsigned flags)
{
    return (int)syscall(SYS_landlock_create_ruleset, rules, bytes, flags);
}

/* Allows these rights: all of them for a folder, those that files can have for a file. A missing
 * path is skipped. Returns 0 on success. */
static int allow(int rules, const char *path, uint64_t allowed)
{
    struct stat info;
    int failed = 0, file = open(path, O_PATH | O_CLOEXEC);
    if (file < 0)
        return 0;
    if (fstat(file, &info) == 0 && !S_ISDIR(info.st_mode))
        allowed &= OF_FILES;
    const path_rule rule = {allowed, file};
    failed = (int)syscall(SYS_landlock_add_rule, rules, RULE_PATH, &rule, 0);
    close(file);
    return failed;
}

static int allow_all(int rules, const stp_sandbox *s, uint64_t known)
{
    /* Host names, certificates, and the libraries that look them up. */
    static const char *const net[] = {"/etc", "/usr", "/lib", "/lib64", "/run", "/dev/urandom"};
    int failed = 0;
    for (int i = 0; i < STP_SANDBOX_PATHS && failed == 0; i++)
        if (s->read[i])
            failed = allow(rules, s->read[i], READ_FILE | READ_FOLDER);
    for (size_t i = 0; s->connects && failed == 0 && i < sizeof net / sizeof *net; i++)
        failed = allow(rules, net[i], READ_FILE | READ_FOLDER);
    char *beside = s->write_beside ? strdup(s->write_beside) : NULL;
    if (beside && failed == 0)
        failed = allow(rules, dirname(beside),
                       (READ_FILE | READ_FOLDER | WRITE_FILE | REMOVE_FILE | MAKE_FILE | TRUNCATE) &
                           known);
    free(beside);
    return failed;
}

stp_status stp_sandbox_enter(const stp_sandbox *sandbox, stp_error *err)
{
    const int version = create_ruleset(NULL, 0, ASK_VERSION);
    if (version < 1)
        return STP_OK;
    const uint64_t known = file_rights[version < 5 ? version - 1 : 4];
    const ruleset rules = {.files = known,
                           .net = version >= 4 && !sandbox->connects ? OF_NET : 0,
                           .scoped = version >= 6 ? OF_SCOPES : 0};
    const size_t bytes = version >= 6 ? 24 : version >= 4 ? 16 : 8;
    int handle = create_ruleset(&rules, bytes, 0);
    bool entered = handle >= 0 && allow_all(handle, sandbox, known) == 0 &&
                   prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
                   syscall(SYS_landlock_restrict_self, handle, 0) == 0;
    int reason = errno;
    if (handle >= 0)
        close(handle);
    if (entered)
        return STP_OK;
    return stp_error_set(err, STP_IO,
                         "the kernel refuses to let go of rights (%s): run again with --no-sandbox",
                         strerror(reason));
}

#else

stp_status stp_sandbox_enter(const stp_sandbox *sandbox, stp_error *err)
{
    (void)sandbox, (void)err;
    return STP_OK;
}

#endif
