/* A chunk file of a million bytes, in memory and on disk, of which bits are flipped one by one. */
#ifndef STP_TESTS_FLIP_FIXTURE_H
#define STP_TESTS_FLIP_FIXTURE_H

#include "formats/chunk/verify.h"
#include "tests/chunk_fixture.h"

#include <fcntl.h>

typedef struct flip_file {
    const char *path;
    int descriptor;
    uint8_t *bytes;
    size_t size;
} flip_file;

/* The file on disk is the bytes, but for what is flipped for a while. */
static inline flip_file flip_file_open(const char *path)
{
    flip_file f = {.path = path};
    f.bytes = fixture_read_file(path, &f.size);
    f.descriptor = open(path, O_WRONLY);
    fixture_require(f.descriptor >= 0);
    return f;
}

static inline void flip_file_close(flip_file *f)
{
    close(f->descriptor);
    free(f->bytes);
}

static inline void flip_bit(const flip_file *f, size_t bit, bool flipped)
{
    uint8_t byte = (uint8_t)(f->bytes[bit / 8] ^ (flipped ? 1u << bit % 8 : 0u));
    fixture_require(pwrite(f->descriptor, &byte, 1, (off_t)(bit / 8)) == 1);
}

static inline stp_status flip_verify(const char *path, stp_pool *pool, stp_error *err)
{
    stp_chunk_file *file = NULL;
    stp_status status = stp_chunk_file_open(&file, path, err);
    if (status == STP_OK)
        status = stp_chunk_file_verify(file, pool, NULL, err);
    stp_chunk_file_close(&file);
    return status;
}

/* What `stipple verify` says with the bit flipped. */
static inline stp_status flip_and_verify(const flip_file *f, size_t bit, stp_pool *pool,
                                         stp_error *err)
{
    flip_bit(f, bit, true);
    stp_status status = flip_verify(f->path, pool, err);
    flip_bit(f, bit, false);
    return status;
}

/* Three tiers: 21 leaves side by side, of patch_count patches each. */
static inline void flip_tree(fixture_tree *tree, uint32_t patch_count)
{
    uint32_t inner[3];
    memset(tree, 0, sizeof *tree);
    tree->box = stp_dbox_empty();
    for (uint32_t i = 0; i < 3; i++) {
        uint32_t leaf[7];
        for (uint32_t k = 0; k < 7; k++) {
            stp_dvec3 origin = {2.0 * patch_count * (7 * i + k), 0.0, 100.0};
            leaf[k] = fixture_add_leaf(tree, 10 * i + k, patch_count, 64, origin);
        }
        inner[i] = fixture_add_parent(tree, leaf, 7);
    }
    fixture_add_parent(tree, inner, 3);
}

static inline flip_file flip_large_file(void)
{
    fixture_tree tree;
    const char *path = fixture_path("large.stipple");
    flip_tree(&tree, 112);
    fixture_require(fixture_write(&tree, path, STP_CODEC_DRACO, NULL) == STP_OK);
    fixture_destroy(&tree);
    return flip_file_open(path);
}

#endif
