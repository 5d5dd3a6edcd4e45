/* Takes two timestamps for each stage. */
#include "runtime/draw/stage_clock.h"

const char *stp_stage_name(stp_stage stage)
{
    static const char *const names[STP_STAGE_COUNT] = {"choose", "project", "resolve", "blend",
                                                       "pull",   "push",    "finish",  "effects"};
    return names[stage];
}

void stp_stage_clock_create(stp_stage_clock *clock, bool software)
{
    *clock = (stp_stage_clock){.software = software};
    glCreateQueries(GL_TIMESTAMP, 2, clock->stamps);
}

void stp_stage_clock_destroy(stp_stage_clock *clock)
{
    glDeleteQueries(2, clock->stamps);
    *clock = (stp_stage_clock){0};
}

void stp_stage_begin(stp_stage_clock *clock)
{
    if (clock == NULL)
        return;
    glQueryCounter(clock->stamps[0], GL_TIMESTAMP);
    /* A software driver's rasteriser takes a stamp after this thread has run the vertex shaders of
     * all draw calls sent together with the stamp, so the stamp is sent alone. A GPU would then
     * also count the time until its next commands arrive. */
    if (clock->software)
        glFlush();
}

void stp_stage_end(stp_stage_clock *clock, stp_stage stage)
{
    GLuint64 begun = 0, ended = 0;
    if (clock == NULL)
        return;
    glQueryCounter(clock->stamps[1], GL_TIMESTAMP);
    glFinish();
    glGetQueryObjectui64v(clock->stamps[0], GL_QUERY_RESULT, &begun);
    glGetQueryObjectui64v(clock->stamps[1], GL_QUERY_RESULT, &ended);
    if (ended > begun)
        clock->ms[stage] += 1e-6 * (double)(ended - begun);
    stp_stage_begin(clock);
}
