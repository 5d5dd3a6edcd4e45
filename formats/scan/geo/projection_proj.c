/* Projections by PROJ: the module that projection.c loads. */
#include "formats/scan/geo/projection.h"

#include "base/memory.h"

#include <math.h>
#include <proj.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ZONE_DEGREES 6.0
#define ZONES 60
/* EPSG codes of zone 1 less 1, of WGS 84 / UTM. */
#define UTM_NORTH 32600
#define UTM_SOUTH 32700

/* On a great circle of the earth. */
#define METRES_BY_DEGREE 111195.0

#define SHOWN_BYTES 60u

struct stp_projection {
    PJ_CONTEXT *context;
    PJ *way;
    char *name, *wkt; /* of the system that positions are brought to */
    double unit, height_unit;
};

/* How much of a definition a message shows: its first line, and not all of a long one. */
static int shown(const char *definition)
{
    const size_t line = strcspn(definition, "\r\n");
    return (int)(line < SHOWN_BYTES ? line : SHOWN_BYTES);
}

static stp_status fail(PJ_CONTEXT *context, const char *from, const char *to, stp_error *err)
{
    const int code = proj_context_errno(context);
    return stp_error_set(err, STP_UNSUPPORTED, "no way from %.*s to %.*s: %s", shown(from), from,
                         shown(to), to,
                         code != 0 ? proj_context_errno_string(context, code)
                                   : "PROJ knows none of the two systems");
}

static void choose_zone(stp_dvec3 at, char out[32])
{
    const double turned = fmod(fmod(at.x + 180.0, 360.0) + 360.0, 360.0);
    const int zone = (int)(turned / ZONE_DEGREES) % ZONES + 1;
    snprintf(out, 32, "EPSG:%d", (at.y < 0.0 ? UTM_SOUTH : UTM_NORTH) + zone);
}

/* NULL: there is none. The system owns the text. */
static const char *wkt_of(PJ_CONTEXT *context, PJ *system)
{
    static const char *const one_line[] = {"MULTILINE=NO", NULL};
    const char *wkt = system ? proj_as_wkt(context, system, PJ_WKT1_GDAL, one_line) : NULL;
    return system && !wkt ? proj_as_wkt(context, system, PJ_WKT2_2019, one_line) : wkt;
}

/* What lengths mean in a system, in metres. */
typedef struct lengths {
    double unit, height_unit;
} lengths;

/* The unit of an axis; 0: there is none. */
static double axis_unit(PJ_CONTEXT *context, const PJ *system, int axis)
{
    double unit = 0.0;
    PJ *axes = system ? proj_crs_get_coordinate_system(context, system) : NULL;
    if (axes == NULL || axis >= proj_cs_get_axis_count(context, axes) ||
        !proj_cs_get_axis_info(context, axes, axis, NULL, NULL, NULL, &unit, NULL, NULL, NULL))
        unit = 0.0;
    proj_destroy(axes);
    return unit;
}

/* The part of a system for x and y, with axes to the east and to the north. NULL: it has none.
 * *out: its lengths, and those of its part for heights. */
static PJ *plane_of(PJ_CONTEXT *context, const char *definition, lengths *out)
{
    PJ *whole = proj_create(context, definition);
    if (whole && proj_get_type(whole) == PJ_TYPE_BOUND_CRS) {
        PJ *bound = whole;
        whole = proj_get_source_crs(context, bound);
        proj_destroy(bound);
    }
    const bool is_compound = whole && proj_get_type(whole) == PJ_TYPE_COMPOUND_CRS;
    PJ *plane = is_compound ? proj_crs_get_sub_crs(context, whole, 0) : whole;
    PJ *heights = is_compound ? proj_crs_get_sub_crs(context, whole, 1) : NULL;
    PJ *turned = plane ? proj_normalize_for_visualization(context, plane) : NULL;
    const bool angles = plane && proj_get_type(plane) != PJ_TYPE_PROJECTED_CRS;
    const double flat = axis_unit(context, plane, 0);
    const double third = heights ? axis_unit(context, heights, 0) : axis_unit(context, plane, 2);
    out->unit = angles ? METRES_BY_DEGREE : flat > 0.0 ? flat : 1.0;
    out->height_unit = third > 0.0 ? third : angles ? 1.0 : out->unit;
    proj_destroy(heights);
    if (is_compound)
        proj_destroy(whole);
    if (turned)
        proj_destroy(plane);
    return turned ? turned : plane;
}

static stp_status describe(stp_projection *p, const char *from, const char *to, stp_error *err)
{
    stp_status status = STP_OK;
    lengths a, b;
    proj_destroy(plane_of(p->context, from, &a));
    proj_destroy(plane_of(p->context, to, &b));
    p->unit = a.unit / b.unit;
    p->height_unit = a.height_unit / b.height_unit;
    PJ *system = proj_create(p->context, to);
    const char *wkt = wkt_of(p->context, system);
    const char *name = system ? proj_get_name(system) : NULL;
    STP_TRY(stp_text_copy(&p->name, name ? name : to, "a coordinate system", err));
    STP_TRY(stp_text_copy(&p->wkt, wkt ? wkt : to, "a coordinate system", err));
done:
    proj_destroy(system);
    return status;
}

static void destroy(stp_projection **projection)
{
    stp_projection *p = *projection;
    proj_destroy(p->way);
    proj_context_destroy(p->context);
    free(p->name);
    free(p->wkt);
    free(p);
    *projection = NULL;
}

static PJ_CONTEXT *make_context(void)
{
    PJ_CONTEXT *context = proj_context_create();
    proj_log_level(context, PJ_LOG_NONE);
    proj_context_set_enable_network(context, 0);
    return context;
}

static stp_status create(stp_projection **out, const char *from, const char *to, stp_dvec3 at,
                         stp_error *err)
{
    stp_status status = STP_OK;
    char zone[32];
    stp_projection *p = NULL;
    STP_TRY(stp_alloc(&p, 1, sizeof *p, "a projection", err));
    p->context = make_context();
    if (to == NULL) {
        choose_zone(at, zone);
        to = zone;
    }
    PJ *plain = proj_create_crs_to_crs(p->context, from, to, NULL);
    p->way = plain ? proj_normalize_for_visualization(p->context, plain) : NULL;
    proj_destroy(plain);
    if (p->way == NULL) {
        status = fail(p->context, from, to, err);
        goto done;
    }
    STP_TRY(describe(p, from, to, err));
    *out = p;
    p = NULL;
done:
    if (p != NULL)
        destroy(&p);
    return status;
}

static stp_dvec3 apply(stp_projection *p, stp_dvec3 position)
{
    const PJ_COORD moved =
        proj_trans(p->way, PJ_FWD, proj_coord(position.x, position.y, 0.0, HUGE_VAL));
    if (!isfinite(moved.xy.x) || !isfinite(moved.xy.y))
        return (stp_dvec3){NAN, NAN, NAN};
    return (stp_dvec3){moved.xy.x, moved.xy.y, position.z * p->height_unit};
}

static const char *name(const stp_projection *p)
{
    return p->name;
}

static const char *wkt(const stp_projection *p)
{
    return p->wkt;
}

static double unit(const stp_projection *p)
{
    return p->unit;
}

static double height_unit(const stp_projection *p)
{
    return p->height_unit;
}

static stp_status system_same(bool *same, const char *a, const char *b, stp_error *err)
{
    stp_status status = STP_OK;
    lengths a_lengths, b_lengths;
    PJ_CONTEXT *context = make_context();
    PJ *first = plane_of(context, a, &a_lengths), *second = plane_of(context, b, &b_lengths);
    if (first == NULL || second == NULL) {
        const char *unknown = first == NULL ? a : b;
        status =
            stp_error_set(err, STP_UNSUPPORTED, "PROJ does not know %.*s", shown(unknown), unknown);
    } else {
        *same = a_lengths.height_unit == b_lengths.height_unit &&
                proj_is_equivalent_to_with_ctx(context, first, second, PJ_COMP_EQUIVALENT) != 0;
    }
    proj_destroy(first);
    proj_destroy(second);
    proj_context_destroy(context);
    return status;
}

static stp_status system_wkt(char **out, const char *definition, stp_error *err)
{
    PJ_CONTEXT *context = make_context();
    PJ *system = proj_create(context, definition);
    const char *wkt = wkt_of(context, system);
    const stp_status status = wkt ? stp_text_copy(out, wkt, "a coordinate system", err)
                                  : stp_error_set(err, STP_UNSUPPORTED, "PROJ does not know %.*s",
                                                  shown(definition), definition);
    proj_destroy(system);
    proj_context_destroy(context);
    return status;
}

const stp_projection_library stp_projection_proj = {
    create, apply, name, wkt, unit, height_unit, destroy, system_wkt, system_same};
