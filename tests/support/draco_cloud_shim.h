/* A complete Draco decoder, to check that our streams are point clouds. */
#ifndef STP_TESTS_SUPPORT_DRACO_CLOUD_SHIM_H
#define STP_TESTS_SUPPORT_DRACO_CLOUD_SHIM_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Reads the only attribute of a point cloud of exactly count points, in order. Returns 0, or -1 if
 * the bytes are no such cloud. */
int draco_cloud_read(const void *bytes, size_t size, int16_t *values, uint32_t count);

#ifdef __cplusplus
}
#endif

#endif
