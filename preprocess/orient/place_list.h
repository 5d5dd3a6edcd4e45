/* Lists of neighbours, packed: the place of each neighbour in the cloud, as a step from the point's
 * own place. Threads: any (pure functions). */
#ifndef STP_PREPROCESS_ORIENT_PLACE_LIST_H
#define STP_PREPROCESS_ORIENT_PLACE_LIST_H

#include <stdint.h>

/* A place takes at most so many bytes. */
#define STP_PLACE_BYTES 5u

/* Writes one place, or STP_NEIGHBOUR_NONE, as the step from self; returns where the next one goes.
 */
uint8_t *stp_place_list_write(uint8_t *at, uint32_t self, uint32_t place);
/* Reads the k places of the list at `at` into out; returns where the next list begins. */
const uint8_t *stp_place_list_next(const uint8_t *at, uint32_t self, unsigned k, uint32_t *out);

#endif
