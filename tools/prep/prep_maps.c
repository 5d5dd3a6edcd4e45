/* Options of prep for elevation maps. */
#include "tools/prep/prep_maps.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

void prep_maps_fill(prep_maps *maps, cli_option out[PREP_MAPS_OPTIONS])
{
    const cli_option options[PREP_MAPS_OPTIONS] = {
        {"--maps", 0, CLI_FLAG, &maps->wanted, NULL,
         "resample the surface as elevation maps; what is no surface stays points", NULL},
        {"--cone", 0, CLI_NUMBER, &maps->cone, "DEGREES",
         "of --maps: how far normals may turn from a map's axis, 10 to 80 (60)", NULL},
        {"--map-error", 0, CLI_NUMBER, &maps->error, "LENGTH",
         "of --maps: points farther than this from their map stay points (by the spacing)", NULL},
        {"--gaps", 0, CLI_CHOICE, &maps->gaps, "overlap|fill",
         "of --maps: maps reach past their borders, or triangles join them (overlap)", NULL},
        {"--map-codec", 0, CLI_CHOICE, &maps->codec, "compact|paper",
         "of --maps: small, or as their paper stores them, to compare with (compact)", NULL},
    };
    memcpy(out, options, sizeof options);
    maps->cone = maps->error = NAN; /* not given */
}

const char *prep_maps_check(prep_maps *maps)
{
    const bool has_cone = !isnan(maps->cone), has_error = !isnan(maps->error);
    if (!maps->wanted && (has_cone || has_error || maps->gaps != 0 || maps->codec != 0))
        return "--cone, --map-error, --gaps and --map-codec are of maps: give --maps, too";
    if (has_cone && !(maps->cone >= 10.0 && maps->cone <= 80.0))
        return "--cone: give 10 to 80";
    if (has_error && !(maps->error > 0.0))
        return "--map-error: give a positive length";
    maps->params = (stp_maps_params){.cone_deg = has_cone ? maps->cone : PREP_MAPS_CONE,
                                     .error = has_error ? maps->error : 0.0,
                                     .fill = maps->gaps == 1,
                                     .paper = maps->codec == 1};
    return NULL;
}

void prep_maps_print(const stp_prep_stats *stats)
{
    const stp_maps_counts *m = &stats->maps;
    if (!stats->makes_maps)
        return;
    fprintf(stderr,
            "%" PRIu64 " maps of %" PRIu64 " samples stand for %" PRIu64 " points; %" PRIu64
            " stay points\n",
            m->maps, m->samples, m->represented, m->as_points);
    if (stats->fills_gaps)
        fprintf(stderr,
                "%" PRIu64 " triangles fill the gaps between maps; %" PRIu64 " edges stay open\n",
                m->between, m->open_edges);
    if (m->represented > 0)
        fprintf(stderr,
                "the surface of the maps is at most %.3g from the points, %.3g on average\n",
                stp_prep_maps_greatest(m, &stats->tree), stp_prep_maps_mean(m, &stats->tree));
}

void prep_maps_json(cJSON *root, const stp_prep_stats *stats)
{
    const stp_maps_counts *m = &stats->maps;
    if (!stats->makes_maps)
        return;
    cJSON *maps = cJSON_AddObjectToObject(root, "maps");
    cJSON_AddNumberToObject(maps, "maps", (double)m->maps);
    cJSON_AddNumberToObject(maps, "samples", (double)m->samples);
    cJSON_AddNumberToObject(maps, "represented", (double)m->represented);
    cJSON_AddNumberToObject(maps, "as_points", (double)m->as_points);
    cJSON_AddNumberToObject(maps, "greatest", stp_prep_maps_greatest(m, &stats->tree));
    cJSON_AddNumberToObject(maps, "mean", stp_prep_maps_mean(m, &stats->tree));
    if (stats->fills_gaps) {
        cJSON_AddNumberToObject(maps, "between", (double)m->between);
        cJSON_AddNumberToObject(maps, "open_edges", (double)m->open_edges);
    }
}
