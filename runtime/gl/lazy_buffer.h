/* A buffer of a fixed size whose memory need not exist before it is written.
 *
 * A software driver fills each new buffer with zeros. The Object Texture has room for a whole
 * model, so that takes longer than drawing the few blocks of the first picture. Such a driver can
 * take memory of ours instead (GL_AMD_pinned_memory): the system hands out a page when the page is
 * first written. A GPU would read that memory over the bus, so on a GPU the buffer is the driver's.
 * Threads: the render thread; any thread may write `memory`. */
#ifndef STP_RUNTIME_GL_LAZY_BUFFER_H
#define STP_RUNTIME_GL_LAZY_BUFFER_H

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct stp_lazy_buffer {
    GLuint name;
    uint8_t *memory; /* the buffer's bytes; NULL: the driver owns them */
    size_t mapped_bytes;
} stp_lazy_buffer;

/* Makes a buffer of our own memory; false, with *out zero and no GL error, if `software` is false,
 * or if the driver or the system has no such memory. software: the driver draws on the CPU. Leaves
 * nothing bound to GL_EXTERNAL_VIRTUAL_MEMORY_BUFFER_AMD. */
bool stp_lazy_buffer_create(stp_lazy_buffer *out, uint64_t bytes, bool software);
/* Waits until the driver no longer uses the memory. Textures may still name the buffer, but nothing
 * may draw with them. Leaves *buffer zero. */
void stp_lazy_buffer_destroy(stp_lazy_buffer *buffer);

#endif
