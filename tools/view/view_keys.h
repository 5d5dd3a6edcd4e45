/* What mouse and keys do in the viewer: one list, which help prints, F1 shows and nothing repeats.
 * Threads: any. */
#ifndef STP_TOOLS_VIEW_VIEW_KEYS_H
#define STP_TOOLS_VIEW_VIEW_KEYS_H

/* X(keys, what), the keys padded to one width. */
#define VIEW_MOUSE_LIST(X)                                                                         \
    X("left drag    ", "turn about the pivot, or what is under the cursor; fly, walk: look about") \
    X("right drag   ", "shift; so does a middle drag, or shift and a left one")                    \
    X("wheel        ", "nearer to what is under the cursor, and back; fly, walk: speed")           \
    X("double click ", "sets the pivot; beside the model: there is none any more")                 \
    X("drop a file  ", "adds a model to the scene")

#define VIEW_KEY_LIST(X)                                                                           \
    X("+ -          ", "finer, coarser: halve, double the threshold")                              \
    X("L            ", "who chooses levels: geometry shader, cpu, full (all samples), compute")    \
    X("R            ", "how gaps are closed: gauss, box, templates, splat, points (not at all)")   \
    X("S            ", "what is shown: phong, lambert, unlit, normal, depth, level, chunk, ...")   \
    X("U            ", "unlit, colours as they are, and back to lit")                              \
    X("C            ", "what colours samples: rgb, none, intensity, class, elevation, outliers")   \
    X("G            ", "palette of intensity and elevation: auto, grey, viridis, heat")            \
    X("K            ", "eye-dome lighting on, off")                                                \
    X("X            ", "clip box on, off; its handles can be dragged")                             \
    X("N            ", "navigation: orbit, fly, walk (keeps to the ground)")                       \
    X("W A S D Q E  ", "fly, walk: forwards, left, back, right, down, up; shift: faster")          \
    X("O            ", "perspective, orthographic")                                                \
    X("H            ", "home: the view it began with")                                             \
    X("M            ", "measure: two clicks give a distance")                                      \
    X("B            ", "keep this view; 1 to 9 lead back to those kept")                           \
    X("P            ", "screenshot, of the size the panel says")                                   \
    X("Ctrl+R       ", "record the camera's path, and end it: stipple fly makes a film of it")     \
    X("Tab          ", "panels on, off")                                                           \
    X("F1           ", "this list")                                                                \
    X("F11          ", "full screen")                                                              \
    X("Esc          ", "ends what is going on, then the program")                                  \
    X("Q            ", "quit")

/* The lines of `stipple view --help`. */
#define VIEW_KEY_LINE(keys, what) "  " keys what "\n"
#define VIEW_KEYS                                                                                  \
    "Mouse:\n" VIEW_MOUSE_LIST(VIEW_KEY_LINE) "Keys (L to G with shift: the cycle runs "           \
                                              "back):\n" VIEW_KEY_LIST(VIEW_KEY_LINE)

#endif
