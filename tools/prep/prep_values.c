/* Parses the values of prep's options. */
#include "tools/prep/prep_values.h"

#include "formats/chunk/sample/normal_grid.h"
#include "formats/scan/number.h"
#include "tools/cli/cli_value.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

stp_status prep_parse_orient(const char *text, stp_prep_params *params, stp_error *err)
{
    static const char *const words[] = {"auto", "file", "propagate", "none"};
    static const stp_orient_mode modes[] = {STP_ORIENT_AUTO, STP_ORIENT_FILE, STP_ORIENT_PROPAGATE,
                                            STP_ORIENT_NONE};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        if (strcmp(text, words[i]) == 0) {
            params->orient = modes[i];
            return STP_OK;
        }
    }
    stp_dvec3 *p = &params->orient_position;
    int used = 0;
    if (sscanf(text, "%lf,%lf,%lf%n", &p->x, &p->y, &p->z, &used) == 3 && !text[used] &&
        stp_dvec3_finite(*p)) {
        params->orient = STP_ORIENT_POSITION;
        return STP_OK;
    }
    return stp_error_set(err, STP_INVALID_ARGUMENT,
                         "--orient %s: give auto, file, propagate, none or a position x,y,z", text);
}

stp_status prep_parse_precision(const char *text, stp_prep_params *params, stp_error *err)
{
    const cli_option number = {.kind = CLI_NUMBER, .target = &params->precision};
    if (!text)
        return STP_OK;
    params->exact = strcmp(text, "exact") == 0;
    if (params->exact || (cli_value_store(&number, text) && params->precision > 0.0))
        return STP_OK;
    return stp_error_set(err, STP_INVALID_ARGUMENT,
                         "--precision %s: give a positive length, or exact", text);
}

stp_status prep_parse_normal_bits(const char *text, stp_prep_params *params, stp_error *err)
{
    uint64_t bits = 0;
    const cli_option number = {.kind = CLI_UINT, .target = &bits};
    if (!text || strcmp(text, "auto") == 0)
        return STP_OK;
    if (!cli_value_store(&number, text) || bits < STP_NORMAL_BITS_LEAST || bits > STP_NORMAL_BITS)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "--normal-bits %s: give %u to %u, or auto",
                             text, STP_NORMAL_BITS_LEAST, STP_NORMAL_BITS);
    params->normal_bits = (unsigned)bits;
    return STP_OK;
}

stp_status prep_parse_sample(const char *text, uint64_t *count, bool *none, stp_error *err)
{
    uint64_t given = 0;
    const cli_option number = {.kind = CLI_UINT, .target = &given};
    *none = text && strcmp(text, "none") == 0;
    if (text && !*none && (!cli_value_store(&number, text) || given == 0))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--sample %s: give the number of points, or none", text);
    *count = given;
    return STP_OK;
}

void prep_grid_fill(prep_grid *grid, cli_option out[PREP_GRID_OPTIONS])
{
    const cli_option options[PREP_GRID_OPTIONS] = {
        {"--grid", 0, CLI_FLAG, &grid->keep, NULL,
         "keep rows and columns, also of PTX and E57, or say why they are not kept", NULL},
        {"--colour", 0, CLI_STRING, &grid->colour, "C.png",
         "colours of a grid of heights or depths: an image of the same size", NULL},
        {"--mask", 0, CLI_STRING, &grid->mask, "M.png",
         "where a grid has no samples: an image of the same size, black there", NULL},
        {"--holes", 0, CLI_CHOICE, &grid->holes, "keep|grow",
         "of grids: holes stay as wide as they are within the threshold, or only grow (keep)",
         NULL},
        {"--invalid", 0, CLI_STRING, &grid->invalid, "V",
         "number of a grid that means: no sample here (what the file says)", NULL},
        {"--spacing", 0, CLI_STRING, &grid->spacing, "DX[,DY]",
         "distance of a grid's columns and rows (the file's, else 1 or a guess)", NULL},
        {"--height-scale", 0, CLI_STRING, &grid->scale, "S", "factor of a grid's numbers (1)",
         NULL},
        {"--pinhole", 0, CLI_STRING, &grid->pinhole, "FX,FY,CX,CY",
         "the grid is a camera's depth image; focal lengths and centre in pixels (guessed)", NULL},
        {"--depth", 0, CLI_CHOICE, &grid->depth, "z|ray",
         "whether depths are measured along the camera's axis or along the ray (z)", NULL},
        {"--disparity", 0, CLI_STRING, &grid->disparity, "F,B",
         "the numbers are disparities: depth = F B / number (F in pixels, B a length)", NULL},
    };
    memcpy(out, options, sizeof options);
}

bool prep_grid_is_given(const prep_grid *g)
{
    return g->colour || g->mask || g->invalid || g->spacing || g->pinhole || g->disparity ||
           g->scale || g->depth != 0;
}

/* Parses `count` numbers with commas between. False if the text is anything else. */
static bool parse_numbers(const char *text, double *out, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const char *end = i + 1 < count ? strchr(text, ',') : text + strlen(text);
        if (!end || !stp_number_parse(text, end, &out[i]) || !isfinite(out[i]))
            return false;
        text = end + 1;
    }
    return true;
}

void prep_region_fill(prep_region *region, cli_option out[PREP_REGION_OPTIONS])
{
    const cli_option options[PREP_REGION_OPTIONS] = {
        {"--bounds", 0, CLI_STRING, &region->bounds, "BOX",
         "only points in x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1, in the input's coordinates", NULL},
        {"--resolution", 0, CLI_NUMBER, &region->resolution, "R",
         "of EPT and COPC, no more points than lie R apart (all)", NULL},
    };
    memcpy(out, options, sizeof options);
}

static bool parse_box(const char *text, stp_scan_region *region)
{
    double n[6];
    const int axes = parse_numbers(text, n, 4) ? 2 : 3;
    bool good = axes == 2 || parse_numbers(text, n, 6);
    region->bounded = true;
    region->min[2] = -INFINITY;
    region->max[2] = INFINITY;
    for (int axis = 0; axis < axes && good; axis++) {
        region->min[axis] = n[axis];
        region->max[axis] = n[axis + axes];
        good = n[axis] <= n[axis + axes];
    }
    return good;
}

stp_status prep_parse_region(const prep_region *given, stp_scan_region *region,
                             const stp_scan_region **out, stp_error *err)
{
    if (given->bounds && !parse_box(given->bounds, region))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--bounds %s: give x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1, the least first",
                             given->bounds);
    if (given->resolution < 0.0)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "--resolution %g: give a positive length",
                             given->resolution);
    region->resolution = given->resolution;
    *out = given->bounds || given->resolution > 0.0 ? region : NULL;
    return STP_OK;
}

static stp_status parse_camera(const prep_grid *grid, stp_grid_params *out, stp_error *err)
{
    double n[4];
    if (grid->pinhole) {
        if (!parse_numbers(grid->pinhole, n, 4) || !(n[0] > 0.0) || !(n[1] > 0.0))
            return stp_error_set(err, STP_INVALID_ARGUMENT,
                                 "--pinhole %s: give FX,FY,CX,CY in pixels, FX and FY positive",
                                 grid->pinhole);
        out->fx = n[0];
        out->fy = n[1];
        out->cx = n[2];
        out->cy = n[3];
    }
    if (grid->disparity) {
        if (!parse_numbers(grid->disparity, n, 2) || !(n[0] > 0.0) || !(n[1] > 0.0))
            return stp_error_set(err, STP_INVALID_ARGUMENT,
                                 "--disparity %s: give F,B, both positive", grid->disparity);
        out->disparity_focal = n[0];
        out->disparity_base = n[1];
    }
    out->along_ray = grid->depth == 1;
    if (!grid->pinhole && (grid->disparity || grid->depth != 0))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--disparity and --depth are about a camera: give --pinhole "
                             "FX,FY,CX,CY, too");
    if (grid->pinhole && grid->spacing)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--spacing is for heights, --pinhole for a camera: give one of them");
    if (grid->disparity && grid->scale)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--height-scale is for heights and depths, not for --disparity: "
                             "multiply B instead");
    return STP_OK;
}

stp_status prep_parse_grid(const prep_grid *grid, stp_grid_params *out, stp_error *err)
{
    double n[2];
    out->colour = grid->colour;
    out->mask = grid->mask;
    out->has_invalid = grid->invalid != NULL;
    if (grid->invalid &&
        !stp_number_parse(grid->invalid, grid->invalid + strlen(grid->invalid), &out->invalid))
        return stp_error_set(err, STP_INVALID_ARGUMENT, "--invalid %s: give a number",
                             grid->invalid);
    if (grid->scale && (!parse_numbers(grid->scale, &out->scale, 1) || out->scale == 0.0))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--height-scale %s: give a number other than 0", grid->scale);
    if (grid->spacing) {
        const bool two = strchr(grid->spacing, ',') != NULL;
        if (!parse_numbers(grid->spacing, n, two ? 2 : 1) || !(n[0] > 0.0) ||
            !((two ? n[1] : n[0]) > 0.0))
            return stp_error_set(err, STP_INVALID_ARGUMENT,
                                 "--spacing %s: give DX or DX,DY, positive", grid->spacing);
        out->dx = n[0];
        out->dy = two ? n[1] : n[0];
    }
    return parse_camera(grid, out, err);
}
