/* A buffer mapped persistently, with fences. */
#include "runtime/stream/upload_ring.h"

#include "runtime/gl/gl_context.h"

/* Makes the ring's buffer by the driver, and maps it. */
static stp_status map_buffer(stp_upload_ring *ring, GLsizeiptr size, stp_error *err)
{
    const GLbitfield flags = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    glCreateBuffers(1, &ring->buffer.name);
    glNamedBufferStorage(ring->buffer.name, size, NULL, flags);
    stp_status status = stp_gl_check("making the upload ring", err);
    if (status == STP_OK)
        ring->memory = glMapNamedBufferRange(ring->buffer.name, 0, size, flags);
    if (status == STP_OK && ring->memory == NULL)
        status = stp_error_set(err, STP_GL,
                               "this OpenGL maps no %lld bytes to upload through: give a smaller "
                               "--gpu-memory",
                               (long long)size);
    return status;
}

stp_status stp_upload_ring_create(stp_upload_ring *out, uint64_t bytes, bool software,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t units = bytes / STP_UPLOAD_UNIT_BYTES, size = units * STP_UPLOAD_UNIT_BYTES;
    stp_upload_ring ring = {.ranges = {.capacity = (uint32_t)units}};
    if (stp_lazy_buffer_create(&ring.buffer, size, software))
        ring.memory = ring.buffer.memory;
    else
        status = map_buffer(&ring, (GLsizeiptr)size, err);
    if (status == STP_OK)
        *out = ring;
    else
        stp_upload_ring_destroy(&ring);
    return status;
}

void stp_upload_ring_destroy(stp_upload_ring *ring)
{
    for (size_t i = 0; i < ring->fence_count; i++)
        glDeleteSync(ring->fences[i].sync);
    if (ring->memory != NULL && ring->buffer.memory == NULL)
        glUnmapNamedBuffer(ring->buffer.name);
    stp_lazy_buffer_destroy(&ring->buffer);
    stp_range_pool_destroy(&ring->ranges);
    *ring = (stp_upload_ring){0};
}

/* Frees the pieces of the oldest fence if it has passed; waits for the fence if asked. */
static bool pass_oldest(stp_upload_ring *ring, bool wait)
{
    if (ring->fence_count == 0)
        return false;
    size_t count = ring->fences[0].count;
    GLenum state = glClientWaitSync(ring->fences[0].sync, GL_SYNC_FLUSH_COMMANDS_BIT, 0);
    while (wait && state == GL_TIMEOUT_EXPIRED)
        state = glClientWaitSync(ring->fences[0].sync, GL_SYNC_FLUSH_COMMANDS_BIT, 1000000000);
    if (state == GL_TIMEOUT_EXPIRED)
        return false;
    glDeleteSync(ring->fences[0].sync);
    for (size_t i = 0; i < count; i++)
        stp_range_pool_give(&ring->ranges, ring->copied[i]);
    for (size_t i = count; i < ring->copied_count; i++)
        ring->copied[i - count] = ring->copied[i];
    for (size_t i = 1; i < ring->fence_count; i++)
        ring->fences[i - 1] = ring->fences[i];
    ring->copied_count -= count;
    ring->fenced_count -= count;
    ring->fence_count--;
    return true;
}

bool stp_upload_ring_take(stp_upload_ring *ring, uint64_t bytes, stp_range *out, stp_status *status,
                          stp_error *err)
{
    uint64_t units = (bytes + STP_UPLOAD_UNIT_BYTES - 1) / STP_UPLOAD_UNIT_BYTES;
    *status = STP_OK;
    return units <= ring->ranges.capacity &&
           stp_range_pool_take(&ring->ranges, (uint32_t)units, out, status, err);
}

uint8_t *stp_upload_ring_memory(const stp_upload_ring *ring, stp_range piece)
{
    return ring->memory + stp_upload_ring_offset(piece);
}

uint64_t stp_upload_ring_offset(stp_range piece)
{
    return (uint64_t)piece.begin * STP_UPLOAD_UNIT_BYTES;
}

void stp_upload_ring_give(stp_upload_ring *ring, stp_range piece)
{
    stp_range_pool_give(&ring->ranges, piece);
}

void stp_upload_ring_copy(const stp_upload_ring *ring, stp_lazy_buffer *buffer, uint64_t from,
                          uint64_t to, uint64_t bytes)
{
    if (bytes == 0)
        return;
    stp_lazy_buffer_fill(buffer, to, bytes);
    glCopyNamedBufferSubData(ring->buffer.name, buffer->name, (GLintptr)from, (GLintptr)to,
                             (GLsizeiptr)bytes);
}

void stp_upload_ring_copied(stp_upload_ring *ring, stp_range piece)
{
    if (!stp_upload_ring_may_copy(ring)) {
        stp_upload_ring_fence(ring);
        if (!stp_upload_ring_may_copy(ring)) /* no fence has passed yet */
            (void)pass_oldest(ring, true);
    }
    ring->copied[ring->copied_count++] = piece;
}

void stp_upload_ring_fence(stp_upload_ring *ring)
{
    while (pass_oldest(ring, ring->fence_count == STP_UPLOAD_FENCES_LIMIT))
        ;
    if (ring->copied_count == ring->fenced_count)
        return;
    ring->fences[ring->fence_count].sync = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    ring->fences[ring->fence_count++].count = ring->copied_count - ring->fenced_count;
    ring->fenced_count = ring->copied_count;
}

bool stp_upload_ring_wait(stp_upload_ring *ring)
{
    return pass_oldest(ring, true);
}

bool stp_upload_ring_may_copy(const stp_upload_ring *ring)
{
    return ring->copied_count < STP_UPLOAD_COPIED_LIMIT;
}
