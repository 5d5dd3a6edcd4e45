/* A whole Draco decoder, to read what our streams say they are: point clouds. */
#ifndef STP_TESTS_SUPPORT_DRACO_CLOUD_SHIM_H
#define STP_TESTS_SUPPORT_DRACO_CLOUD_SHIM_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The only attribute of a point cloud of exactly count points, in order. 0, or -1 where the bytes
 * are none such. */
int draco_cloud_read(const void *bytes, size_t size, int16_t *values, uint32_t count);

#ifdef __cplusplus
}
#endif

#endif
