/* A buffer of a fixed size whose memory need not exist before it is written.
 *
 * A software driver fills each new buffer with zeros. The Object Texture has room for a whole
 * model, so that takes longer than drawing the few blocks of the first picture. Such a driver can
 * take memory of ours instead (GL_AMD_pinned_memory): the system hands out a page when the page is
 * first written. A GPU would read that memory over the bus; its driver can instead make a buffer of
 * pages and give memory to those that are about to be written (GL_ARB_sparse_buffer). An NVIDIA
 * H200 takes 1.2 s to make 2 GB at once.
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
    /* Pages of the driver's: which of them have memory; NULL: all. */
    bool *has_memory;
    bool lacks_memory; /* some page could not get any: what was copied there is lost */
    uint64_t page_bytes;
} stp_lazy_buffer;

/* Makes a buffer of our own memory; false, with *out zero and no GL error, if `software` is false,
 * or if the driver or the system has no such memory. software: the driver draws on the CPU. Leaves
 * nothing bound to GL_EXTERNAL_VIRTUAL_MEMORY_BUFFER_AMD. */
bool stp_lazy_buffer_create(stp_lazy_buffer *out, uint64_t bytes, bool software);
/* Makes a buffer of the driver's, if it can of pages without memory. No GL error may be pending;
 * one is left to glGetError. */
void stp_lazy_buffer_create_pages(stp_lazy_buffer *out, uint64_t bytes);
/* Gives memory to the pages of a range that is about to be written. If there is none, sets
 * lacks_memory, and what is written there is lost. No GL error may be pending, and none is left. */
void stp_lazy_buffer_fill(stp_lazy_buffer *buffer, uint64_t begin, uint64_t bytes);
/* Reads a few bytes. By a copy, since drivers may keep a whole buffer near the processor from then
 * on if it is read itself; NVIDIA's (580) then freed a buffer of pages wrongly. */
void stp_lazy_buffer_read(const stp_lazy_buffer *buffer, uint64_t begin, uint64_t bytes, void *out);
/* Waits until the driver no longer uses the memory. Textures may still name the buffer, but nothing
 * may draw with them. Leaves *buffer zero. */
void stp_lazy_buffer_destroy(stp_lazy_buffer *buffer);

#endif
