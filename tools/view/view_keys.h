/* What mouse and keys do in the viewer. --help prints this list and F1 shows it; no other list
 * repeats it. Threads: any. */
#ifndef STP_TOOLS_VIEW_VIEW_KEYS_H
#define STP_TOOLS_VIEW_VIEW_KEYS_H

/* X(keys, what they do); the keys are padded to one width. */
#define VIEW_MOUSE_LIST(X)                                                                         \
    X("left drag    ", "turn about the pivot, else what is under the cursor; fly, walk: look")     \
    X("right drag   ", "shift the view; middle drag, or shift and left drag, does the same")       \
    X("wheel        ", "move to what is under the cursor, or back; fly, walk: change the speed")   \
    X("double click ", "set the pivot; beside the model: remove the pivot")                        \
    X("drop a file  ", "add a model to the scene")

#define VIEW_KEY_LIST(X)                                                                           \
    X("+ -          ", "finer, coarser: halve, double the threshold")                              \
    X("L            ", "what chooses levels: geometry shader, cpu, full (all samples), compute")   \
    X("R            ", "how gaps are closed: gauss, box, templates, splat, points (not at all)")   \
    X("S            ", "what is shown: phong, lambert, unlit, normal, depth, level, chunk, ...")   \
    X("U            ", "unlit (colours without light), and back to lit")                           \
    X("C            ", "what colours samples: rgb, none, intensity, class, elevation, outliers")   \
    X("G            ", "palette of intensity and elevation: auto, grey, viridis, heat")            \
    X("K            ", "eye-dome lighting on, off")                                                \
    X("X            ", "clip box on, off; its handles can be dragged")                             \
    X("N            ", "navigation: orbit, fly, walk (keeps to the ground)")                       \
    X("W A S D Q E  ", "fly, walk: forwards, left, back, right, down, up; shift: faster")          \
    X("O            ", "perspective, orthographic")                                                \
    X("H            ", "home: the view at the start")                                              \
    X("M            ", "measure: two clicks give a distance")                                      \
    X("T            ", "profile: the heights along the last measured line")                        \
    X("F            ", "mark what is under the cursor")                                            \
    X("V , . Y      ",                                                                             \
      "--beside: both sides, left, right alone; move the divider; swap the sides")                 \
    X("B            ", "keep this view; 1 to 9 go to the kept views")                              \
    X("P            ", "screenshot in the size set in the panel")                                  \
    X("Ctrl+O       ", "open another model or scan, or add one; lists those opened last")          \
    X("Ctrl+R       ", "start or end recording the camera's path; stipple fly films the path")     \
    X("Tab          ", "panels on, off")                                                           \
    X("F1           ", "this list")                                                                \
    X("F11          ", "full screen")                                                              \
    X("Esc          ", "end what is going on, then the program")                                   \
    X("Q            ", "quit")

/* The lines of `stipple view --help`. */
#define VIEW_KEY_LINE(keys, what) "  " keys what "\n"
#define VIEW_KEYS                                                                                  \
    "Mouse:\n" VIEW_MOUSE_LIST(                                                                    \
        VIEW_KEY_LINE) "Keys (shift with L to G steps backwards):\n" VIEW_KEY_LIST(VIEW_KEY_LINE)

#endif
