/* Finds what a column of points means by its name. */
#include "formats/scan/column_name.h"

#include <string.h>

#define STP_NAME_CHARS_MAX 32

/* In order of preference: an earlier name wins over a later one with the same meaning. */
static const struct {
    const char *name;
    stp_column column;
} known_names[] = {
    {"x", STP_COLUMN_X},
    {"xcoordinate", STP_COLUMN_X},
    {"xcoord", STP_COLUMN_X},
    {"coordinatex", STP_COLUMN_X},
    {"coordx", STP_COLUMN_X},
    {"positionx", STP_COLUMN_X},
    {"posx", STP_COLUMN_X},
    {"px", STP_COLUMN_X},
    {"pointx", STP_COLUMN_X},
    {"xm", STP_COLUMN_X},
    {"xmm", STP_COLUMN_X},
    {"points:0", STP_COLUMN_X},
    {"points0", STP_COLUMN_X},
    {"pointsmxyz:0", STP_COLUMN_X},
    {"xyz0", STP_COLUMN_X},
    {"localx", STP_COLUMN_X},
    {"worldx", STP_COLUMN_X},
    {"globalx", STP_COLUMN_X},
    {"utmx", STP_COLUMN_X},
    {"easting", STP_COLUMN_X},
    {"east", STP_COLUMN_X},
    {"e", STP_COLUMN_X},
    {"rechtswert", STP_COLUMN_X},
    {"ostwert", STP_COLUMN_X},
    {"ost", STP_COLUMN_X},
    {"este", STP_COLUMN_X},
    {"est", STP_COLUMN_X},
    {"leste", STP_COLUMN_X},
    {"longitude", STP_COLUMN_X},
    {"long", STP_COLUMN_X},
    {"lon", STP_COLUMN_X},
    {"lng", STP_COLUMN_X},
    {"y", STP_COLUMN_Y},
    {"ycoordinate", STP_COLUMN_Y},
    {"ycoord", STP_COLUMN_Y},
    {"coordinatey", STP_COLUMN_Y},
    {"coordy", STP_COLUMN_Y},
    {"positiony", STP_COLUMN_Y},
    {"posy", STP_COLUMN_Y},
    {"py", STP_COLUMN_Y},
    {"pointy", STP_COLUMN_Y},
    {"ym", STP_COLUMN_Y},
    {"ymm", STP_COLUMN_Y},
    {"points:1", STP_COLUMN_Y},
    {"points1", STP_COLUMN_Y},
    {"pointsmxyz:1", STP_COLUMN_Y},
    {"xyz1", STP_COLUMN_Y},
    {"localy", STP_COLUMN_Y},
    {"worldy", STP_COLUMN_Y},
    {"globaly", STP_COLUMN_Y},
    {"utmy", STP_COLUMN_Y},
    {"northing", STP_COLUMN_Y},
    {"north", STP_COLUMN_Y},
    {"n", STP_COLUMN_Y},
    {"hochwert", STP_COLUMN_Y},
    {"nordwert", STP_COLUMN_Y},
    {"nord", STP_COLUMN_Y},
    {"norte", STP_COLUMN_Y},
    {"latitude", STP_COLUMN_Y},
    {"lat", STP_COLUMN_Y},
    {"z", STP_COLUMN_Z},
    {"zcoordinate", STP_COLUMN_Z},
    {"zcoord", STP_COLUMN_Z},
    {"coordinatez", STP_COLUMN_Z},
    {"coordz", STP_COLUMN_Z},
    {"positionz", STP_COLUMN_Z},
    {"posz", STP_COLUMN_Z},
    {"pz", STP_COLUMN_Z},
    {"pointz", STP_COLUMN_Z},
    {"zm", STP_COLUMN_Z},
    {"zmm", STP_COLUMN_Z},
    {"points:2", STP_COLUMN_Z},
    {"points2", STP_COLUMN_Z},
    {"pointsmxyz:2", STP_COLUMN_Z},
    {"xyz2", STP_COLUMN_Z},
    {"localz", STP_COLUMN_Z},
    {"worldz", STP_COLUMN_Z},
    {"globalz", STP_COLUMN_Z},
    {"utmz", STP_COLUMN_Z},
    {"elevation", STP_COLUMN_Z},
    {"elev", STP_COLUMN_Z},
    {"altitude", STP_COLUMN_Z},
    {"alt", STP_COLUMN_Z},
    {"height", STP_COLUMN_Z},
    {"h", STP_COLUMN_Z},
    {"hoehe", STP_COLUMN_Z},
    {"cota", STP_COLUMN_Z},
    {"quota", STP_COLUMN_Z},
    {"altura", STP_COLUMN_Z},
    {"h\xc3\xb6he", STP_COLUMN_Z}, /* UTF-8, Latin 1 */
    {"h\xf6he", STP_COLUMN_Z},
    {"red", STP_COLUMN_RED},
    {"r", STP_COLUMN_RED},
    {"diffusered", STP_COLUMN_RED},
    {"colorred", STP_COLUMN_RED},
    {"colorr", STP_COLUMN_RED},
    {"rf", STP_COLUMN_RED},
    {"rgb:0", STP_COLUMN_RED},
    {"rgb0", STP_COLUMN_RED},
    {"rot", STP_COLUMN_RED},
    {"rouge", STP_COLUMN_RED},
    {"rojo", STP_COLUMN_RED},
    {"rosso", STP_COLUMN_RED},
    {"green", STP_COLUMN_GREEN},
    {"g", STP_COLUMN_GREEN},
    {"diffusegreen", STP_COLUMN_GREEN},
    {"colorgreen", STP_COLUMN_GREEN},
    {"colorg", STP_COLUMN_GREEN},
    {"gf", STP_COLUMN_GREEN},
    {"rgb:1", STP_COLUMN_GREEN},
    {"rgb1", STP_COLUMN_GREEN},
    {"gruen", STP_COLUMN_GREEN},
    {"gr\xc3\xbc"
     "n",
     STP_COLUMN_GREEN},
    {"gr\xfc"
     "n",
     STP_COLUMN_GREEN},
    {"vert", STP_COLUMN_GREEN},
    {"verde", STP_COLUMN_GREEN},
    {"blue", STP_COLUMN_BLUE},
    {"b", STP_COLUMN_BLUE},
    {"diffuseblue", STP_COLUMN_BLUE},
    {"colorblue", STP_COLUMN_BLUE},
    {"colorb", STP_COLUMN_BLUE},
    {"bf", STP_COLUMN_BLUE},
    {"rgb:2", STP_COLUMN_BLUE},
    {"rgb2", STP_COLUMN_BLUE},
    {"blau", STP_COLUMN_BLUE},
    {"bleu", STP_COLUMN_BLUE},
    {"azul", STP_COLUMN_BLUE},
    {"blu", STP_COLUMN_BLUE},
    {"nx", STP_COLUMN_NX},
    {"normalx", STP_COLUMN_NX},
    {"ny", STP_COLUMN_NY},
    {"normaly", STP_COLUMN_NY},
    {"nz", STP_COLUMN_NZ},
    {"normalz", STP_COLUMN_NZ},
    {"intensity", STP_COLUMN_INTENSITY},
    {"intensities", STP_COLUMN_INTENSITY},
    {"i", STP_COLUMN_INTENSITY},
    {"int", STP_COLUMN_INTENSITY},
    {"reflectance", STP_COLUMN_INTENSITY},
    {"reflectivity", STP_COLUMN_INTENSITY},
    {"refl", STP_COLUMN_INTENSITY},
    {"remission", STP_COLUMN_INTENSITY},
    {"amplitude", STP_COLUMN_INTENSITY},
    {"gray", STP_COLUMN_INTENSITY},
    {"grey", STP_COLUMN_INTENSITY},
    {"luminance", STP_COLUMN_INTENSITY},
    {"texture32", STP_COLUMN_INTENSITY}, /* of Photoneo */
    {"intensitaet", STP_COLUMN_INTENSITY},
    {"intensit\xc3\xa4"
     "t",
     STP_COLUMN_INTENSITY},
    {"intensit\xe4"
     "t",
     STP_COLUMN_INTENSITY},
    {"intensite", STP_COLUMN_INTENSITY},
    {"intensit\xc3\xa9", STP_COLUMN_INTENSITY},
    {"intensit\xe9", STP_COLUMN_INTENSITY},
    {"classification", STP_COLUMN_CLASS},
    {"class", STP_COLUMN_CLASS},
    {"classid", STP_COLUMN_CLASS},
    {"label", STP_COLUMN_CLASS},
    {"klasse", STP_COLUMN_CLASS},
    {"classe", STP_COLUMN_CLASS},
    {"klassifikation", STP_COLUMN_CLASS},
};

#define STP_NAMES (sizeof known_names / sizeof *known_names)

/* Leaves out what does not count. False: it is longer than any known name. */
static bool simplify(const char *begin, const char *end, char name[STP_NAME_CHARS_MAX + 1])
{
    size_t length = 0;
    for (const char *at = begin; at < end && *at != '('; at++) {
        if (*at == '[') { /* an index, or a unit */
            if (end - at < 3 || at[1] < '0' || at[1] > '9' || at[2] != ']')
                break;
            at++;
        }
        if (*at == ']')
            break;
        if (*at == '_' || *at == '-' || *at == '.' || *at == ' ')
            continue;
        if (length == STP_NAME_CHARS_MAX)
            return false;
        name[length++] = *at >= 'A' && *at <= 'Z' ? (char)(*at - 'A' + 'a') : *at;
    }
    name[length] = '\0';
    return true;
}

size_t stp_column_find_name(const char *begin, const char *end)
{
    char name[STP_NAME_CHARS_MAX + 1];
    if (!simplify(begin, end, name))
        return STP_COLUMN_NO_NAME;
    const size_t skip = strlen(name) > 6 && memcmp(name, "scalar", 6) == 0 ? 6 : 0;
    for (size_t i = 0; i < STP_NAMES; i++)
        if (strcmp(known_names[i].name, name + skip) == 0)
            return i;
    return STP_COLUMN_NO_NAME;
}

bool stp_column_is_packed(const char *begin, const char *end)
{
    static const char *const names[] = {"rgb",      "rgba",      "argb",   "color",  "colour",
                                        "rgbcolor", "rgbcolour", "hex",    "hexrgb", "rgbhex",
                                        "hexcolor", "hexcolour", "rgbint", "farbe"};
    char name[STP_NAME_CHARS_MAX + 1];
    if (!simplify(begin, end, name))
        return false;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(names[i], name) == 0)
            return true;
    return false;
}

stp_column stp_column_by_name(size_t name)
{
    return name < STP_NAMES ? known_names[name].column : STP_COLUMN_NONE;
}

bool stp_column_is_angle(size_t name)
{
    return name < STP_NAMES && known_names[name].column <= STP_COLUMN_Y &&
           known_names[name].name[0] == 'l';
}

const char *stp_column_name(stp_column column)
{
    static const char *const names[] = {"x",  "y",  "z",         "red",   "green",    "blue",  "nx",
                                        "ny", "nz", "intensity", "class", "not read", "colour"};
    return names[column];
}
