/* Makes buffers of pages that the system hands out when they are written. */
#include "runtime/gl/lazy_buffer.h"

#include <sys/mman.h>

/* Drivers may read some bytes behind a buffer's end. */
#define MARGIN_BYTES 4096

bool stp_lazy_buffer_create(stp_lazy_buffer *out, uint64_t bytes, bool software)
{
    stp_lazy_buffer b = {.mapped_bytes = (size_t)bytes + MARGIN_BYTES};
    *out = (stp_lazy_buffer){0};
    if (!software || bytes == 0 || !epoxy_has_gl_extension("GL_AMD_pinned_memory"))
        return false;
    void *memory =
        mmap(NULL, b.mapped_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED)
        return false;
    b.memory = memory;
    (void)madvise(memory, b.mapped_bytes, MADV_HUGEPAGE); /* fewer page faults */
    glGenBuffers(1, &b.name);
    glBindBuffer(GL_EXTERNAL_VIRTUAL_MEMORY_BUFFER_AMD, b.name);
    glBufferData(GL_EXTERNAL_VIRTUAL_MEMORY_BUFFER_AMD, (GLsizeiptr)bytes, memory, GL_DYNAMIC_COPY);
    glBindBuffer(GL_EXTERNAL_VIRTUAL_MEMORY_BUFFER_AMD, 0);
    if (glGetError() != GL_NO_ERROR) {
        stp_lazy_buffer_destroy(&b);
        return false;
    }
    *out = b;
    return true;
}

void stp_lazy_buffer_destroy(stp_lazy_buffer *b)
{
    if (b->name != 0)
        glDeleteBuffers(1, &b->name);
    if (b->memory != NULL) {
        glFinish();
        munmap(b->memory, b->mapped_bytes);
    }
    *b = (stp_lazy_buffer){0};
}
