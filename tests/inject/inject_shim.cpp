// Preloaded into a program: lets the n-th call of a name fail. tests/fixtures/injection.h says how
// it is used.
//
// STIPPLE_INJECT="name n errno [short|on]": the n-th call of this name fails with this errno. Calls
// count if they come from the program, from one of our libraries or their C++ libraries, or from
// libcurl. short: instead of failing, reads and writes take half of what was asked. on: all later
// calls fail too.
// STIPPLE_INJECT_COUNTS=FILE: writes a line "name count" for each name at the end.
// STIPPLE_INJECT_REST: asks a program with a window to end (SIGTERM) once it draws no more.
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <fts.h>
#include <link.h>
#include <netdb.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <spawn.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/xattr.h>
#include <time.h>
#include <unistd.h>
#include <unwind.h>

#define NAMES(X)                                                                                   \
    X(malloc), X(calloc), X(realloc), X(strdup), X(_Znwm), X(_Znam), X(open), X(openat), X(fopen), \
        X(read), X(pread), X(write), X(pwrite), X(fread), X(fwrite), X(fputc), X(fflush),          \
        X(fclose), X(fseek), X(close), X(fsync), X(fstat), X(fstatat), X(stat), X(statvfs),        \
        X(mmap), X(memfd_create), X(posix_fallocate), X(rename), X(renameat), X(link), X(linkat),  \
        X(unlink), X(unlinkat), X(mkdir), X(rmdir), X(mkostemp), X(opendir), X(fdopendir),         \
        X(readdir), X(fts_open), X(fts_read), X(flock), X(pthread_create), X(pthread_mutex_init),  \
        X(pthread_cond_init), X(posix_spawnp), X(socketpair), X(poll), X(madvise), X(__openat_2),  \
        X(renameat2), X(lstat), X(realpath), X(getrandom), X(fsetxattr), X(fgetxattr), X(lseek),   \
        X(socket), X(connect), X(send), X(recv), X(getaddrinfo), X(getsockname), X(getpeername),   \
        X(getsockopt), X(setsockopt)

namespace
{

enum name {
#define X(n) NAME_##n
    NAMES(X),
#undef X
    NAME_COUNT
};

const char *const names[NAME_COUNT] = {
#define X(n) #n
    NAMES(X)
#undef X
};

struct range {
    uintptr_t begin, end;
};

range ranges[64], loader;
std::atomic<int> range_count;
std::atomic<unsigned> counts[NAME_COUNT];
int wanted = NAME_COUNT, failure, shortened, lasting;
unsigned wanted_count;
int told = -1; // file of the counts; opened at once: a sandbox may close the way later

// dlsym needs memory before it can find malloc.
alignas(16) char early[1 << 16];
std::atomic<size_t> early_used;

bool is_early(const void *p)
{
    return p >= early && p < early + sizeof early;
}

void *early_memory(size_t size)
{
    size_t at = early_used.fetch_add((size + 31) & ~size_t{15});
    if (at + size > sizeof early)
        abort();
    return early + at;
}

template <typename function> function next(const char *name)
{
    return reinterpret_cast<function>(dlsym(RTLD_NEXT, name));
}

int add_ranges(struct dl_phdr_info *info, size_t, void *first)
{
    const char *file = info->dlpi_name;
    bool ours = *static_cast<bool *>(first) || strstr(file, "stipple") ||
                strstr(file, "libdraco") || strstr(file, "libOpenMesh");
    *static_cast<bool *>(first) = false;
    bool loads = strstr(file, "/ld-linux") != nullptr;
    if (strstr(file, "inject"))
        return 0;
    for (int i = 0; (ours || loads) && i < info->dlpi_phnum; i++) {
        const ElfW(Phdr) *h = &info->dlpi_phdr[i];
        int at = range_count;
        if (h->p_type == PT_LOAD && (h->p_flags & PF_X) && at < 64) {
            (loads ? loader : ranges[at]) = {info->dlpi_addr + h->p_vaddr,
                                             info->dlpi_addr + h->p_vaddr + h->p_memsz};
            range_count = at + !loads;
        }
    }
    return 0;
}

// libcurl is loaded only when an address is opened.
bool is_curl(const void *caller)
{
    struct dl_find_object found;
    return _dl_find_object(const_cast<void *>(caller), &found) == 0 &&
           strstr(found.dlfo_link_map->l_name, "libcurl");
}

bool is_ours(const void *caller)
{
    uintptr_t at = reinterpret_cast<uintptr_t>(caller);
    for (int i = 0, n = range_count; i < n; i++)
        if (at >= ranges[i].begin && at < ranges[i].end)
            return true;
    return is_curl(caller);
}

// While a library is being loaded, its initialisers run, and nobody could catch what they throw.
// They use C++ templates that may be the same functions as ours.
_Unwind_Reason_Code look_at(struct _Unwind_Context *frame, void *opening)
{
    uintptr_t at = _Unwind_GetIP(frame);
    *static_cast<bool *>(opening) |= at >= loader.begin && at < loader.end;
    return _URC_NO_REASON;
}

bool is_opening()
{
    bool opening = false;
    _Unwind_Backtrace(look_at, &opening);
    return opening;
}

bool strikes(name which, const void *caller)
{
    if (!is_ours(caller))
        return false;
    unsigned n = counts[which].fetch_add(1) + 1;
    if (which != wanted || n < wanted_count || (n > wanted_count && !lasting))
        return false;
    if (is_opening())
        return false;
    errno = failure;
    return true;
}

__attribute__((constructor)) void begin()
{
    const char *path = getenv("STIPPLE_INJECT_COUNTS");
    told = path ? open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666) : -1;
    char which[32], mode[16] = "";
    bool first = true;
    const char *text = getenv("STIPPLE_INJECT");
    if (text && sscanf(text, "%31s %u %d %15s", which, &wanted_count, &failure, mode) >= 3)
        for (int i = 0; i < NAME_COUNT; i++)
            if (strcmp(names[i], which) == 0)
                wanted = i;
    shortened = strcmp(mode, "short") == 0;
    lasting = strcmp(mode, "on") == 0;
    dl_iterate_phdr(add_ranges, &first);
}

__attribute__((destructor)) void end()
{
    for (int i = 0; told >= 0 && i < NAME_COUNT; i++)
        dprintf(told, "%s %u\n", names[i], counts[i].load());
}

} // namespace

#define HERE __builtin_return_address(0)
// Defines a function that fails with a value.
#define FAIL_BY(value, result, function, parameters, arguments)                                    \
    extern "C" result function parameters                                                          \
    {                                                                                              \
        static auto real = next<result(*) parameters>(#function);                                  \
        if (strikes(NAME_##function, HERE))                                                        \
            return value;                                                                          \
        return real arguments;                                                                     \
    }

extern "C" {

void *malloc(size_t size)
{
    static void *(*real)(size_t);
    static thread_local bool asking;
    if (!real) {
        if (asking)
            return early_memory(size);
        asking = true;
        real = next<void *(*)(size_t)>("malloc");
        asking = false;
    }
    return strikes(NAME_malloc, HERE) ? nullptr : real(size);
}

void *calloc(size_t count, size_t size)
{
    static void *(*real)(size_t, size_t);
    static thread_local bool asking;
    if (!real) {
        if (asking)
            return memset(early_memory(count * size), 0, count * size);
        asking = true;
        real = next<void *(*)(size_t, size_t)>("calloc");
        asking = false;
    }
    return strikes(NAME_calloc, HERE) ? nullptr : real(count, size);
}

void *realloc(void *old, size_t size)
{
    static void *(*real)(void *, size_t) = next<void *(*)(void *, size_t)>("realloc");
    if (is_early(old)) {
        void *moved = malloc(size);
        return moved ? memcpy(moved, old, size) : nullptr;
    }
    return strikes(NAME_realloc, HERE) ? nullptr : real(old, size);
}

void free(void *old)
{
    static void (*real)(void *);
    static thread_local bool asking;
    if (is_early(old) || asking) // asking: dlsym's own words, which stay
        return;
    if (!real) {
        asking = true;
        real = next<void (*)(void *)>("free");
        asking = false;
    }
    real(old);
}

int open(const char *path, int flags, ...)
{
    static auto real = next<int (*)(const char *, int, ...)>("open");
    va_list list;
    va_start(list, flags);
    mode_t mode = va_arg(list, mode_t);
    va_end(list);
    return strikes(NAME_open, HERE) ? -1 : real(path, flags, mode);
}

int openat(int folder, const char *path, int flags, ...)
{
    static auto real = next<int (*)(int, const char *, int, ...)>("openat");
    va_list list;
    va_start(list, flags);
    mode_t mode = va_arg(list, mode_t);
    va_end(list);
    return strikes(NAME_openat, HERE) ? -1 : real(folder, path, flags, mode);
}

#define TRANSFER(function, parameters, arguments, half)                                            \
    ssize_t function parameters                                                                    \
    {                                                                                              \
        static auto real = next<ssize_t(*) parameters>(#function);                                 \
        if (!strikes(NAME_##function, HERE))                                                       \
            return real arguments;                                                                 \
        return shortened && size > 1 ? real half : -1;                                             \
    }
TRANSFER(read, (int file, void *to, size_t size), (file, to, size), (file, to, size / 2))
TRANSFER(write, (int file, const void *from, size_t size), (file, from, size),
         (file, from, size / 2))
TRANSFER(pread, (int file, void *to, size_t size, off_t at), (file, to, size, at),
         (file, to, size / 2, at))
TRANSFER(pwrite, (int file, const void *from, size_t size, off_t at), (file, from, size, at),
         (file, from, size / 2, at))
TRANSFER(send, (int file, const void *from, size_t size, int flags), (file, from, size, flags),
         (file, from, size / 2, flags))
TRANSFER(recv, (int file, void *to, size_t size, int flags), (file, to, size, flags),
         (file, to, size / 2, flags))

// A failing close still closes: POSIX leaves this open, Linux closes.
int close(int file)
{
    static auto real = next<int (*)(int)>("close");
    bool struck = strikes(NAME_close, HERE);
    int error = errno, result = real(file);
    if (struck)
        errno = error;
    return struck ? -1 : result;
}

int fclose(FILE *file)
{
    static auto real = next<int (*)(FILE *)>("fclose");
    bool struck = strikes(NAME_fclose, HERE);
    int error = errno, result = real(file);
    if (struck)
        errno = error;
    return struck ? EOF : result;
}

// Sets glibc's error flag: a stream remembers that it has failed.
static void spoil(FILE *file)
{
    file->_flags |= 0x20;
}

size_t fread(void *to, size_t size, size_t count, FILE *file)
{
    static auto real = next<size_t (*)(void *, size_t, size_t, FILE *)>("fread");
    if (!strikes(NAME_fread, HERE))
        return real(to, size, count, file);
    spoil(file);
    return 0;
}

size_t fwrite(const void *from, size_t size, size_t count, FILE *file)
{
    static auto real = next<size_t (*)(const void *, size_t, size_t, FILE *)>("fwrite");
    if (!strikes(NAME_fwrite, HERE))
        return real(from, size, count, file);
    spoil(file);
    return 0;
}

int fputc(int c, FILE *file)
{
    static auto real = next<int (*)(int, FILE *)>("fputc");
    if (!strikes(NAME_fputc, HERE))
        return real(c, file);
    spoil(file);
    return EOF;
}

int fflush(FILE *file)
{
    static auto real = next<int (*)(FILE *)>("fflush");
    if (!strikes(NAME_fflush, HERE))
        return real(file);
    if (file)
        spoil(file);
    return EOF;
}
}

FAIL_BY(nullptr, char *, strdup, (const char *text), (text))
FAIL_BY(nullptr, FILE *, fopen, (const char *path, const char *mode), (path, mode))
FAIL_BY(-1, int, fseek, (FILE * file, long at, int from), (file, at, from))
FAIL_BY(-1, int, fsync, (int file), (file))
FAIL_BY(-1, int, fstat, (int file, struct stat *to), (file, to))
FAIL_BY(-1, int, fstatat, (int folder, const char *path, struct stat *to, int flags),
        (folder, path, to, flags))
FAIL_BY(-1, int, stat, (const char *path, struct stat *to), (path, to))
FAIL_BY(-1, int, statvfs, (const char *path, struct statvfs *to), (path, to))
FAIL_BY(MAP_FAILED, void *, mmap,
        (void *at, size_t size, int rights, int flags, int file, off_t from),
        (at, size, rights, flags, file, from))
FAIL_BY(-1, int, memfd_create, (const char *name, unsigned flags), (name, flags))
FAIL_BY(failure, int, posix_fallocate, (int file, off_t at, off_t size), (file, at, size))
FAIL_BY(-1, int, rename, (const char *from, const char *to), (from, to))
FAIL_BY(-1, int, renameat, (int a, const char *from, int b, const char *to), (a, from, b, to))
FAIL_BY(-1, int, link, (const char *from, const char *to), (from, to))
FAIL_BY(-1, int, linkat, (int a, const char *from, int b, const char *to, int flags),
        (a, from, b, to, flags))
FAIL_BY(-1, int, unlink, (const char *path), (path))
FAIL_BY(-1, int, unlinkat, (int folder, const char *path, int flags), (folder, path, flags))
FAIL_BY(-1, int, mkdir, (const char *path, mode_t mode), (path, mode))
FAIL_BY(-1, int, rmdir, (const char *path), (path))
FAIL_BY(-1, int, mkostemp, (char *path, int flags), (path, flags))
FAIL_BY(nullptr, DIR *, opendir, (const char *path), (path))
FAIL_BY(nullptr, DIR *, fdopendir, (int file), (file))
FAIL_BY(nullptr, struct dirent *, readdir, (DIR * folder), (folder))
FAIL_BY(nullptr, FTS *, fts_open,
        (char *const *paths, int options, int (*order)(const FTSENT **, const FTSENT **)),
        (paths, options, order))
FAIL_BY(nullptr, FTSENT *, fts_read, (FTS * walk), (walk))
FAIL_BY(-1, int, flock, (int file, int operation), (file, operation))
FAIL_BY(failure, int, pthread_create,
        (pthread_t * thread, const pthread_attr_t *settings, void *(*start)(void *),
         void *argument),
        (thread, settings, start, argument))
FAIL_BY(failure, int, pthread_mutex_init,
        (pthread_mutex_t * mutex, const pthread_mutexattr_t *settings), (mutex, settings))
FAIL_BY(failure, int, pthread_cond_init,
        (pthread_cond_t * condition, const pthread_condattr_t *settings), (condition, settings))
FAIL_BY(failure, int, posix_spawnp,
        (pid_t * pid, const char *file, const posix_spawn_file_actions_t *actions,
         const posix_spawnattr_t *settings, char *const *arguments, char *const *environment),
        (pid, file, actions, settings, arguments, environment))
FAIL_BY(-1, int, socketpair, (int domain, int type, int protocol, int *ends),
        (domain, type, protocol, ends))
FAIL_BY(-1, int, poll, (struct pollfd * files, nfds_t count, int timeout), (files, count, timeout))
FAIL_BY(-1, int, madvise, (void *at, size_t size, int advice), (at, size, advice))
FAIL_BY(-1, int, __openat_2, (int folder, const char *path, int flags), (folder, path, flags))
FAIL_BY(-1, int, renameat2, (int a, const char *from, int b, const char *to, unsigned flags),
        (a, from, b, to, flags))
FAIL_BY(-1, int, lstat, (const char *path, struct stat *to), (path, to))
FAIL_BY(nullptr, char *, realpath, (const char *path, char *to), (path, to))
FAIL_BY(-1, ssize_t, getrandom, (void *to, size_t size, unsigned flags), (to, size, flags))
FAIL_BY(-1, int, fsetxattr, (int file, const char *name, const void *value, size_t size, int flags),
        (file, name, value, size, flags))
FAIL_BY(-1, ssize_t, fgetxattr, (int file, const char *name, void *value, size_t size),
        (file, name, value, size))
FAIL_BY(-1, off_t, lseek, (int file, off_t at, int from), (file, at, from))
FAIL_BY(-1, int, socket, (int domain, int type, int protocol), (domain, type, protocol))
FAIL_BY(-1, int, connect, (int file, const struct sockaddr *to, socklen_t size), (file, to, size))
FAIL_BY(EAI_AGAIN, int, getaddrinfo,
        (const char *node, const char *service, const struct addrinfo *wanted,
         struct addrinfo **found),
        (node, service, wanted, found))
FAIL_BY(-1, int, getsockname, (int file, struct sockaddr *at, socklen_t *size), (file, at, size))
FAIL_BY(-1, int, getpeername, (int file, struct sockaddr *at, socklen_t *size), (file, at, size))
FAIL_BY(-1, int, getsockopt, (int file, int level, int name, void *value, socklen_t *size),
        (file, level, name, value, size))
FAIL_BY(-1, int, setsockopt, (int file, int level, int name, const void *value, socklen_t size),
        (file, level, name, value, size))

// ---- the window at rest ----

static std::atomic<uint64_t> drawn_ns; // when a picture was last shown

static uint64_t now_ns()
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<uint64_t>(now.tv_sec) * 1000000000u + static_cast<uint64_t>(now.tv_nsec);
}

// A second without a new picture is rest. Some programs never rest, because they ask again for what
// they could not read: they get five seconds.
static void *end_at_rest(void *)
{
    const struct timespec pause = {0, 20000000};
    const uint64_t begin = now_ns();
    while (now_ns() - drawn_ns < 1000000000u && now_ns() - begin < 5000000000u)
        nanosleep(&pause, nullptr);
    kill(getpid(), SIGTERM);
    return nullptr;
}

extern "C" void glfwSwapBuffers(void *window)
{
    static auto real = next<void (*)(void *)>("glfwSwapBuffers");
    static const bool asked = getenv("STIPPLE_INJECT_REST") != nullptr;
    pthread_t thread;
    real(window);
    if (asked && drawn_ns.exchange(now_ns()) == 0)
        (void)pthread_create(&thread, nullptr, end_at_rest, nullptr);
}

void *operator new(size_t size)
{
    static auto real = next<void *(*)(size_t)>("_Znwm");
    if (strikes(NAME__Znwm, HERE))
        throw std::bad_alloc();
    return real(size);
}

void *operator new[](size_t size)
{
    static auto real = next<void *(*)(size_t)>("_Znam");
    if (strikes(NAME__Znam, HERE))
        throw std::bad_alloc();
    return real(size);
}
