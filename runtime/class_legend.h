/* What the numbers of classes mean: names and colours by the ASPRS LAS specification (1.4 R15), and
 * which of them a model has. The colours are those of shaders/shade/palette.glsl, to which a test
 * compares them. Threads: any. */
#ifndef STP_RUNTIME_CLASS_LEGEND_H
#define STP_RUNTIME_CLASS_LEGEND_H

#include "runtime/cut/model.h"

#include <stddef.h>
#include <stdint.h>

/* In lower case, as "low vegetation"; NULL where the specification names none. */
const char *stp_class_name(uint8_t class_id);
/* Red, green, blue of --colour class, 0 to 1. */
void stp_class_colour(uint8_t class_id, float rgb[3]);
/* The class of a name of so many letters, in any case, with - or _ for a blank; -1 if there is
 * none.
 */
int stp_class_find(const char *name, size_t length);

/* Sets bit c % 32 of word c / 32 where a sample of the model's root has class c; all others are 0.
 * The root holds few samples of a large model: a rare class may have none there. Errors: those of
 * reading a chunk. */
stp_status stp_model_classes(const stp_model *model, uint32_t classes[8], stp_error *err);

#endif
