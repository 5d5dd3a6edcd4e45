/* Class numbers explained: names and colours after the ASPRS LAS specification (1.4 R15), and which
 * classes a model has. The colours equal those of shaders/shade/palette.glsl; a test compares the
 * two. Threads: any. */
#ifndef STP_RUNTIME_CLASS_LEGEND_H
#define STP_RUNTIME_CLASS_LEGEND_H

#include "runtime/cut/model.h"

#include <stddef.h>
#include <stdint.h>

/* The name in lower case, as "low vegetation"; NULL if the specification names none. */
const char *stp_class_name(uint8_t class_id);
/* The red, green, blue of --colour class, each 0 to 1. */
void stp_class_colour(uint8_t class_id, float rgb[3]);
/* The class whose name these `length` letters are, in any case, with - or _ for a blank; -1 if
 * there is none. */
int stp_class_find(const char *name, size_t length);

/* Sets bit c % 32 of word c / 32 if a sample in the model's root has class c, and clears all other
 * bits. The root holds few samples of a large model, so a rare class may be missing. Errors: those
 * of reading a chunk. */
stp_status stp_model_classes(const stp_model *model, uint32_t classes[8], stp_error *err);

#endif
