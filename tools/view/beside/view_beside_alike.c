/* What is alike on both sides and what is not: keeps settings alike that were, names the others. */
#include "tools/view/view_app.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#define SETTING(member) offsetof(stp_draw_params, member), sizeof((stp_draw_params *)NULL)->member

/* The members of stp_draw_params that a user sets. If names tell them: the words of an enumeration
 * or a bool, or what stands before and after a number. */
static const struct {
    size_t at, bytes;
    const char *words, *before, *after;
} settings[] = {
    {SETTING(lod), DRAW_LODS, "levels ", ""},
    {SETTING(reconstruct), DRAW_RECONSTRUCTIONS, "", ""},
    {SETTING(shade), DRAW_SHADES, "", ""},
    {SETTING(palette), DRAW_PALETTES, "palette ", ""},
    {SETTING(cull), DRAW_CULLS, "cull ", ""},
    {SETTING(grid_draw), DRAW_GRIDS, "grids as ", ""},
    {SETTING(maps_as), DRAW_MAPS, "maps as ", ""},
    {SETTING(smooth_edges), "hard|smooth", "", " edges"},
    {SETTING(radius_cap_px), NULL, "radius cap ", " px"},
    {SETTING(overlay), NULL, "overlay ", ""},
    {SETTING(edl), NULL, "eye-dome ", ""},
    {SETTING(contour_step), NULL, "contours ", ""},
    {SETTING(threshold_px), NULL, NULL, NULL},
    {SETTING(every_sample), NULL, NULL, NULL},
    {SETTING(colour), NULL, NULL, NULL},
    {SETTING(colour_range), NULL, NULL, NULL},
    {SETTING(terms), NULL, NULL, NULL},
    {SETTING(light), NULL, NULL, NULL},
    {SETTING(contour_base), NULL, NULL, NULL},
    {SETTING(exaggerate), NULL, NULL, NULL},
    {SETTING(exaggerate_about), NULL, NULL, NULL},
    {SETTING(clip.enabled), NULL, NULL, NULL},
    {SETTING(clip.box), NULL, NULL, NULL},
    {SETTING(hidden_classes), NULL, NULL, NULL},
};
#define SETTING_COUNT (sizeof settings / sizeof *settings)

static bool is_alike(size_t i, const stp_draw_params *a, const stp_draw_params *b)
{
    return memcmp((const char *)a + settings[i].at, (const char *)b + settings[i].at,
                  settings[i].bytes) == 0;
}

void view_beside_link(viewer *v)
{
    view_beside *b = &v->beside;
    for (size_t i = 0; i < SETTING_COUNT && !b->apart; i++)
        if (is_alike(i, &b->params, &b->linked) && !is_alike(i, &v->control.params, &b->linked))
            memcpy((char *)&b->params + settings[i].at, (char *)&v->control.params + settings[i].at,
                   settings[i].bytes);
    b->linked = v->control.params;
}

static void say(char *name, const char *before, const char *what, const char *after)
{
    const size_t used = strlen(name);
    snprintf(name + used, VIEW_SIDE_NAME - used, "%s%s%s%s", used > 0 ? ", " : "", before, what,
             after);
}

static bool differ(const char *a, const char *b)
{
    return a && b ? strcmp(a, b) != 0 : a != b;
}

/* Says what the table does not. */
static void say_others(const viewer *v, char *name)
{
    const view_beside *b = &v->beside;
    const stp_draw_params *p = &v->control.params;
    char word[64];
    if (p->every_sample != b->params.every_sample || p->threshold_px != b->params.threshold_px) {
        snprintf(word, sizeof word, "threshold %.4g px", p->threshold_px);
        say(name, "", p->every_sample ? "every sample" : word, "");
    }
    if (p->colour != b->params.colour ||
        differ(v->options->attribute, b->other.options->attribute)) {
        draw_options_word(DRAW_COLOURS, (int)p->colour, word);
        say(name, "",
            p->colour == STP_COLOUR_INTENSITY && v->options->attribute ? v->options->attribute
                                                                       : word,
            "");
    }
    if (differ(v->options->where, b->other.options->where))
        say(name, "", v->options->where ? v->options->where : "all samples", "");
}

void view_beside_name(const viewer *v, char name[VIEW_SIDE_NAME])
{
    const view_beside *b = &v->beside;
    name[0] = '\0';
    if (differ(v->scene.models[0].path, b->other.scene.models[0].path))
        say(name, "", v->scene.models[0].name, "");
    say_others(v, name);
    for (size_t i = 0; i < SETTING_COUNT; i++) {
        char word[64];
        const void *at = (const char *)&v->control.params + settings[i].at;
        if (!settings[i].before || is_alike(i, &v->control.params, &b->params))
            continue;
        if (!settings[i].words)
            snprintf(word, sizeof word, "%.4g", *(const double *)at);
        else
            draw_options_word(
                settings[i].words,
                settings[i].bytes == sizeof(bool) ? *(const bool *)at : *(const int *)at, word);
        say(name, settings[i].before, word, settings[i].after);
    }
    if (name[0] == '\0')
        say(name, "", v->scene.models[0].name, "");
}
