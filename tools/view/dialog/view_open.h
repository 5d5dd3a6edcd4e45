/* The viewer's dialog for opening files, on Ctrl+O: a field for a path or an address, recent files,
 * and a folder. A press on a name puts it into the field; a second press opens it. Threads: the
 * main thread only. */
#ifndef STP_TOOLS_VIEW_DIALOG_VIEW_OPEN_H
#define STP_TOOLS_VIEW_DIALOG_VIEW_OPEN_H

#include "tools/view/dialog/view_folder.h"
#include "tools/view/dialog/view_recent.h"
#include "tools/view/kept/view_files.h"

#include <stdbool.h>

typedef enum view_open_choice {
    VIEW_OPEN_NOTHING,
    VIEW_OPEN_INSTEAD, /* of the models that are shown */
    VIEW_OPEN_BESIDE,  /* added to the scene */
} view_open_choice;

/* Zero is closed. */
typedef struct view_open {
    bool shown, begun;       /* begun: the field got the keyboard at first */
    view_open_choice choice; /* what the user chose to do with `field`; the caller resets it */
    char field[VIEW_PATH_BYTES];
    char path[VIEW_PATH_BYTES]; /* of the folder */
    view_folder folder;
    view_recent recent;
    char why[VIEW_PATH_BYTES + 200]; /* what is to be said of the folder; "": nothing */
} view_open;

/* Shows the dialog with the folder that `model`, a path or an address, lies in. */
void view_open_begin(view_open *o, const char *model);
/* Draws it, between stp_ui_begin and stp_ui_end; nothing if it is closed. A choice closes it. */
void view_open_draw(view_open *o, double width, double height, double scale);
void view_open_clear(view_open *o);

#endif
