/* Lists of neighbours, packed: the place of each neighbour in the cloud, as a step from the point's
 * own place. Threads: any (pure functions). */
#ifndef STP_PREPROCESS_CLOUD_PLACE_LIST_H
#define STP_PREPROCESS_CLOUD_PLACE_LIST_H

#include <stdint.h>

/* A place takes at most so many bytes. */
#define STP_PLACE_BYTES 6u

/* Writes one place, or STP_PLACE_NONE, as the step from self; returns where the next one goes.
 */
uint8_t *stp_place_list_write(uint8_t *at, uint64_t self, uint64_t place);
/* Reads the k places of the list at `at` into out; returns where the next list begins. */
const uint8_t *stp_place_list_next(const uint8_t *at, uint64_t self, unsigned k, uint64_t *out);

#endif
