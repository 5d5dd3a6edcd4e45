/* xdrop WINDOW URI...: drags files to a window as a file manager does (XDND 5) and drops them in
 * its middle. Exits with 0 once the window confirms. */
#include <X11/Xatom.h>
#include <X11/Xlib.h>

#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LIST_BYTES 65536
#define WAIT_MS 10000

typedef struct drop {
    Display *display;
    Window target, source;
    Atom selection, enter, position, status, leave_drop, finished, copy, uris;
    char list[LIST_BYTES];
} drop;

static Atom atom(const drop *d, const char *name)
{
    return XInternAtom(d->display, name, False);
}

static void tell(const drop *d, Atom type, const long data[5])
{
    XEvent event = {.xclient = {.type = ClientMessage,
                                .display = d->display,
                                .window = d->target,
                                .message_type = type,
                                .format = 32}};
    memcpy(event.xclient.data.l, data, 5 * sizeof(long));
    XSendEvent(d->display, d->target, False, NoEventMask, &event);
    XFlush(d->display);
}

/* Answers the target's request for the names. */
static void answer(const drop *d, const XSelectionRequestEvent *request)
{
    XEvent event = {.xselection = {.type = SelectionNotify,
                                   .display = d->display,
                                   .requestor = request->requestor,
                                   .selection = request->selection,
                                   .target = request->target,
                                   .property = request->property,
                                   .time = request->time}};
    XChangeProperty(d->display, request->requestor, request->property, d->uris, 8, PropModeReplace,
                    (const unsigned char *)d->list, (int)strlen(d->list));
    XSendEvent(d->display, request->requestor, False, NoEventMask, &event);
    XFlush(d->display);
}

/* Waits for a message of the target; returns 0 if none comes in time. */
static int await(const drop *d, Atom type)
{
    struct pollfd ready = {.fd = ConnectionNumber(d->display), .events = POLLIN};
    for (;;) {
        XEvent event;
        if (XPending(d->display) == 0 && poll(&ready, 1, WAIT_MS) <= 0)
            return 0;
        if (XPending(d->display) == 0)
            continue;
        XNextEvent(d->display, &event);
        if (event.type == SelectionRequest)
            answer(d, &event.xselectionrequest);
        if (event.type == ClientMessage && event.xclient.message_type == type)
            return 1;
    }
}

static int run(drop *d)
{
    XWindowAttributes a;
    Window child;
    int x = 0, y = 0;
    const long self = (long)d->source, version = 5L << 24;
    if (!XGetWindowAttributes(d->display, d->target, &a))
        return 1;
    XTranslateCoordinates(d->display, d->target, a.root, a.width / 2, a.height / 2, &x, &y, &child);
    XSetSelectionOwner(d->display, d->selection, d->source, CurrentTime);
    tell(d, d->enter, (long[5]){self, version, (long)d->uris, 0, 0});
    tell(d, d->position, (long[5]){self, 0, (long)x << 16 | y, CurrentTime, (long)d->copy});
    if (!await(d, d->status))
        return 1;
    tell(d, d->leave_drop, (long[5]){self, 0, CurrentTime, 0, 0});
    return await(d, d->finished) ? 0 : 1;
}

int main(int argc, char **argv)
{
    drop d = {.display = XOpenDisplay(NULL)};
    if (d.display == NULL || argc < 3) {
        fprintf(stderr, "usage: xdrop WINDOW URI... (and a display)\n");
        return 2;
    }
    d.target = (Window)strtoul(argv[1], NULL, 0);
    d.source = XCreateSimpleWindow(d.display, DefaultRootWindow(d.display), 0, 0, 1, 1, 0, 0, 0);
    d.selection = atom(&d, "XdndSelection");
    d.enter = atom(&d, "XdndEnter");
    d.position = atom(&d, "XdndPosition");
    d.status = atom(&d, "XdndStatus");
    d.leave_drop = atom(&d, "XdndDrop");
    d.finished = atom(&d, "XdndFinished");
    d.copy = atom(&d, "XdndActionCopy");
    d.uris = atom(&d, "text/uri-list");
    for (int i = 2; i < argc; i++) {
        size_t used = strlen(d.list);
        snprintf(d.list + used, sizeof d.list - used, "%s\r\n", argv[i]);
    }
    int code = run(&d);
    XCloseDisplay(d.display);
    return code;
}
