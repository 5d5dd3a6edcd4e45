/* Preloaded by test_sandbox.sh: when the program ends, tries what a hostile file might make it do,
 * and says on stderr what was allowed. */
#include <arpa/inet.h>
#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

namespace
{
bool opens(const char *path, int flags)
{
    int file = open(path, flags | O_CLOEXEC, 0600);
    if (file >= 0)
        close(file);
    return file >= 0;
}

/* Whether a connection to the loopback is allowed; nobody listens there. */
bool connects()
{
    sockaddr_in to = {};
    to.sin_family = AF_INET;
    to.sin_port = htons(1);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    int client = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    bool allowed =
        connect(client, reinterpret_cast<sockaddr *>(&to), sizeof to) == 0 || errno == ECONNREFUSED;
    close(client);
    return allowed;
}

__attribute__((destructor)) void tell()
{
    std::fprintf(stderr, "reads %d writes %d connects %d\n", opens("/etc/passwd", O_RDONLY),
                 opens("/tmp/stipple-sandbox-test", O_WRONLY | O_CREAT), connects());
    unlink("/tmp/stipple-sandbox-test");
}
} // namespace
