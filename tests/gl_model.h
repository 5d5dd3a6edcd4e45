/* One known model, drawn by all tests of a group in a folder of their own. */
#ifndef STP_TESTS_GL_MODEL_H
#define STP_TESTS_GL_MODEL_H

#include "tests/gl_fixture.h"
#include "tests/model_fixture.h"
#include "tests/scan_fixture.h"

/* For cmocka_run_group_tests: the group's state is a gl_fixture. */
static inline int gl_model_enter(void **state, const model_recipe *recipe)
{
    static gl_fixture f;
    if (scan_fixture_enter(state) != 0)
        return 1;
    model_fixture_build("model.stipple", recipe);
    gl_fixture_open(&f, "model.stipple", NULL);
    *state = &f;
    return 0;
}

static inline int gl_model_leave(void **state)
{
    gl_fixture_close(*state);
    return scan_fixture_leave(state);
}

#endif
