/* Runs Xvfb as a virtual display and asks xdotool for titles. */
#include "tests/support/display.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#define START_MS 20000

static pid_t process; /* Xvfb's; 0: not running */

static void become_display(int told)
{
    char descriptor[16];
    int nowhere = open("/dev/null", O_WRONLY);
    snprintf(descriptor, sizeof descriptor, "%d", told);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (nowhere >= 0)
        (void)dup2(nowhere, 2);
    /* without -noreset Xvfb starts anew whenever the last window closes */
    execlp("Xvfb", "Xvfb", "-displayfd", descriptor, "-screen", "0", "640x480x24", "-nocursor",
           "-noreset", "-nolisten", "tcp", (char *)NULL);
    _exit(127);
}

/* Reads the display's number; Xvfb writes it and a line's end when it is ready. */
static bool read_number(int from, char number[16])
{
    size_t got = 0;
    struct pollfd ready = {.fd = from, .events = POLLIN};
    while (got < 15 && poll(&ready, 1, START_MS) == 1 && read(from, number + got, 1) == 1) {
        if (number[got] == '\n') {
            number[got] = '\0';
            return got > 0;
        }
        got++;
    }
    return false;
}

bool display_start(void)
{
    int ends[2];
    char number[16], name[20];
    if (system("command -v Xvfb xdotool >/dev/null 2>&1") != 0) {
        printf("no windows: Xvfb or xdotool is not installed\n");
        return false;
    }
    if (pipe(ends) != 0)
        return false;
    process = fork();
    if (process == 0) {
        close(ends[0]);
        become_display(ends[1]);
    }
    close(ends[1]);
    bool started = process > 0 && read_number(ends[0], number);
    close(ends[0]);
    if (!started) {
        printf("no windows: Xvfb does not start\n");
        display_stop();
        return false;
    }
    snprintf(name, sizeof name, ":%s", number);
    return setenv("DISPLAY", name, 1) == 0;
}

void display_stop(void)
{
    if (process > 0) {
        kill(process, SIGTERM);
        waitpid(process, NULL, 0);
    }
    process = 0;
}

bool display_has_title(const char *text)
{
    char command[200];
    snprintf(command, sizeof command, "xdotool search --onlyvisible --name '%s' >/dev/null 2>&1",
             text);
    return system(command) == 0;
}
