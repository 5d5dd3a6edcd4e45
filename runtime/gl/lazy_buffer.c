/* Makes buffers of pages that the system hands out when they are written. */
#include "runtime/gl/lazy_buffer.h"

#include <stdlib.h>
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

/* Pages get memory in steps of about so many bytes, since each step is a call to the driver. */
#define STEP_BYTES (UINT64_C(4) << 20)

/* Makes a buffer without memory; false if the driver has none. */
static bool create_sparse(stp_lazy_buffer *b, uint64_t bytes)
{
    GLint page = 0;
    if (!epoxy_has_gl_extension("GL_ARB_sparse_buffer") || bytes <= STEP_BYTES)
        return false;
    glGetIntegerv(GL_SPARSE_BUFFER_PAGE_SIZE_ARB, &page);
    if (page <= 0)
        return false;
    b->page_bytes = (STEP_BYTES + (uint64_t)page - 1) / (uint64_t)page * (uint64_t)page;
    uint64_t pages = (bytes + b->page_bytes - 1) / b->page_bytes;
    b->has_memory = calloc((size_t)pages, sizeof(bool));
    if (b->has_memory == NULL)
        return false;
    glCreateBuffers(1, &b->name);
    glNamedBufferStorage(b->name, (GLsizeiptr)(pages * b->page_bytes), NULL,
                         GL_SPARSE_STORAGE_BIT_ARB | GL_DYNAMIC_STORAGE_BIT);
    if (glGetError() == GL_NO_ERROR)
        return true;
    glDeleteBuffers(1, &b->name);
    free(b->has_memory);
    return false;
}

void stp_lazy_buffer_create_pages(stp_lazy_buffer *out, uint64_t bytes)
{
    stp_lazy_buffer b = {0};
    if (!create_sparse(&b, bytes)) {
        b = (stp_lazy_buffer){0};
        glCreateBuffers(1, &b.name);
        glNamedBufferStorage(b.name, (GLsizeiptr)bytes, NULL, GL_DYNAMIC_STORAGE_BIT);
    }
    *out = b;
}

void stp_lazy_buffer_fill(stp_lazy_buffer *b, uint64_t begin, uint64_t bytes)
{
    if (b->has_memory == NULL || bytes == 0)
        return;
    for (uint64_t i = begin / b->page_bytes; i <= (begin + bytes - 1) / b->page_bytes; i++) {
        if (b->has_memory[i])
            continue;
        glNamedBufferPageCommitmentARB(b->name, (GLintptr)(i * b->page_bytes),
                                       (GLsizeiptr)b->page_bytes, GL_TRUE);
        b->has_memory[i] = glGetError() == GL_NO_ERROR;
        b->lacks_memory |= !b->has_memory[i];
    }
}

void stp_lazy_buffer_read(const stp_lazy_buffer *b, uint64_t begin, uint64_t bytes, void *out)
{
    GLuint copy;
    glCreateBuffers(1, &copy);
    glNamedBufferStorage(copy, (GLsizeiptr)bytes, NULL, 0);
    glCopyNamedBufferSubData(b->name, copy, (GLintptr)begin, 0, (GLsizeiptr)bytes);
    glGetNamedBufferSubData(copy, 0, (GLsizeiptr)bytes, out);
    glDeleteBuffers(1, &copy);
}

void stp_lazy_buffer_destroy(stp_lazy_buffer *b)
{
    if (b->name != 0)
        glDeleteBuffers(1, &b->name);
    if (b->memory != NULL) {
        glFinish();
        munmap(b->memory, b->mapped_bytes);
    }
    free(b->has_memory);
    *b = (stp_lazy_buffer){0};
}
