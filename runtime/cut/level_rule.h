/* Compiles the error rule of shaders/project/level_rule.glsl as C, so that the CPU and the GPU
 * decide by the same source. */
#ifndef STP_RUNTIME_CUT_LEVEL_RULE_H
#define STP_RUNTIME_CUT_LEVEL_RULE_H

#include <math.h>
#include <stdbool.h>

#define STP_RULE static inline
#define STP_SQRT sqrtf
#define STP_MAX(a, b) ((a) > (b) ? (a) : (b)) /* fmaxf is a call */
#define STP_MIN(a, b) ((a) < (b) ? (a) : (b))
#define STP_ABS fabsf

#include "shaders/project/level_rule.glsl"

#undef STP_RULE
#undef STP_SQRT
#undef STP_MAX
#undef STP_MIN
#undef STP_ABS

#endif
