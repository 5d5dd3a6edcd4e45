/* Runs the trial of two roads, and chooses one. */
#include "runtime/draw/road.h"

#include <string.h>

bool stp_road_is_software(void)
{
    static const char *const names[] = {"llvmpipe", "softpipe", "SwiftShader", "swrast"};
    const char *renderer = (const char *)glGetString(GL_RENDERER);
    for (size_t i = 0; renderer != NULL && i < sizeof names / sizeof names[0]; i++)
        if (strstr(renderer, names[i]) != NULL)
            return true;
    return false;
}

void stp_road_begin(stp_road *road, bool software)
{
    *road = (stp_road){.lod = software ? STP_LOD_COMPUTE : STP_LOD_GEOMETRY, .decided = software};
}

static stp_lod tried(int frame)
{
    return frame % 2 == 0 ? STP_LOD_GEOMETRY : STP_LOD_COMPUTE;
}

/* Once the GPU has reported all times, takes the road whose best frame was faster. The first frame
 * of each road does not count. */
static void decide(stp_road *road)
{
    GLuint64 best[2] = {UINT64_MAX, UINT64_MAX};
    GLint there = 0;
    glGetQueryObjectiv(road->stamps[STP_ROAD_TRIAL_FRAMES - 1][1], GL_QUERY_RESULT_AVAILABLE,
                       &there);
    if (!there)
        return;
    for (int i = 2; i < STP_ROAD_TRIAL_FRAMES; i++) {
        GLuint64 stamps[2];
        for (int k = 0; k < 2; k++)
            glGetQueryObjectui64v(road->stamps[i][k], GL_QUERY_RESULT, &stamps[k]);
        GLuint64 took = stamps[1] - stamps[0];
        best[i % 2] = took < best[i % 2] ? took : best[i % 2];
    }
    road->lod = best[1] < best[0] ? tried(1) : tried(0);
    stp_road_end(road);
}

stp_lod stp_road_take(stp_road *road, bool streams)
{
    if (!road->decided && road->frame == STP_ROAD_TRIAL_FRAMES)
        decide(road);
    road->tries = streams && !road->decided && road->frame < STP_ROAD_TRIAL_FRAMES;
    if (!road->tries)
        return road->lod;
    GLuint *stamps = road->stamps[road->frame];
    if (stamps[0] == 0)
        glCreateQueries(GL_TIMESTAMP, 2, stamps);
    glQueryCounter(stamps[0], GL_TIMESTAMP);
    return tried(road->frame);
}

void stp_road_leave(stp_road *road, bool whole)
{
    if (!road->tries)
        return;
    road->tries = false;
    glQueryCounter(road->stamps[road->frame][1], GL_TIMESTAMP);
    if (whole)
        road->frame++;
}

void stp_road_end(stp_road *road)
{
    for (int i = 0; i < STP_ROAD_TRIAL_FRAMES; i++)
        if (road->stamps[i][0] != 0)
            glDeleteQueries(2, road->stamps[i]);
    memset(road->stamps, 0, sizeof road->stamps);
    road->decided = true;
}
