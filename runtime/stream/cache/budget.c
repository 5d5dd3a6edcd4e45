/* Divides the budgets. */
#include "runtime/stream/cache/budget.h"

#include "runtime/cut/level_choice.h"
#include "runtime/stream/cache/object_texture.h"
#include "runtime/stream/payload_store.h"
#include "runtime/stream/stream.h"

/* Memory for decoding a block, with Draco's tables, in sizes of a decoded block. An estimate, not
 * measured. */
#define DECODING_BLOCKS 3
/* Most bytes of the upload ring: on a GPU, what some frames under way may hold. A software driver
 * passes fences sooner, and a small ring stays in the processor's cache. */
static const uint64_t ring_most_bytes[2] = {UINT64_C(32) << 20, UINT64_C(8) << 20};
#define PAYLOADS_LEAST 2
/* If there is room, allots this many times what a whole scene needs: for gaps, and for a block's
 * finer version while the coarser one is drawn. */
#define SCENE_SHARE 1.25
/* Slots besides one for each block, for finer versions if all blocks are resident and some are
 * coarse: at least so many, and as many as loads may be under way. */
#define SPARE_SLOTS_LEAST 16
/* What else is kept of each block: entries of tables of the model, the cache and the stream. */
#define TABLE_BYTES 160
/* A block has squares or spots, not both. */
#define PATCH_MIRROR_BYTES                                                                         \
    (sizeof(stp_mirror_patch) + sizeof(stp_patch_brief) + sizeof(stp_gpu_patch) +                  \
     STP_SPOTS_A_PATCH * sizeof(stp_spot))
_Static_assert(sizeof(stp_square) <= STP_SPOTS_A_PATCH * sizeof(stp_spot), "squares take less");

/* Sums and maxima over a scene's blocks. */
typedef struct demand {
    uint64_t samples, patches, payloads;
    uint64_t most_samples, most_patches, most_payload, most_decoded;
} demand;

static uint64_t larger(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

static uint64_t smaller(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

static demand measure(const stp_scene *scene)
{
    demand d = {0};
    for (uint32_t i = 0; i < scene->block_count; i++) {
        const stp_block *b = &scene->blocks[i];
        uint64_t samples = 0, payload = stp_block_payload_bytes(b, 0);
        payload += STP_PAYLOAD_UNIT_BYTES;
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            samples += b->sample_count[l];
        d.samples += samples;
        d.patches += b->patch_count;
        d.payloads += payload;
        d.most_samples = larger(d.most_samples, samples);
        d.most_patches = larger(d.most_patches, b->patch_count);
        d.most_payload = larger(d.most_payload, payload);
        d.most_decoded = larger(d.most_decoded, stp_block_memory_bytes(b, 0));
    }
    return d;
}

static uint64_t texture_bytes(uint64_t samples, uint64_t patches)
{
    return stp_texels_most(samples, patches) * STP_TEXEL_BYTES + patches * sizeof(stp_gpu_patch);
}

/* Refuses a budget, and says the least that would be enough for two blocks. */
static stp_status refuse(const stp_scene *scene, const char *which, uint64_t bytes, uint64_t needed,
                         stp_error *err)
{
    return stp_error_set(err, STP_LIMIT,
                         "%s: a %s memory of %llu bytes holds not even two blocks: give "
                         "--%s-memory %lluM or more",
                         stp_chunk_file_path(scene->models[0].model->file),
                         which[0] == 'g' ? "GPU" : "CPU", (unsigned long long)bytes, which,
                         1 + (((unsigned long long)needed) >> 20));
}

/* The number of decoders, as long as a quarter of the budget holds their working memory. */
static unsigned choose_decoders(uint64_t each, uint64_t cpu, unsigned wanted)
{
    uint64_t fit = cpu / 4 / larger(each, 1);
    return (unsigned)larger(1, smaller(wanted, fit));
}

static uint32_t slots_of(const stp_scene *scene)
{
    uint64_t spare = larger(SPARE_SLOTS_LEAST, smaller(scene->block_count, STP_STREAM_LOADS_LIMIT));
    return (uint32_t)smaller(scene->block_count + spare, STP_GPU_SLOTS_LIMIT);
}

/* If the whole scene has no room, so much of the GPU's is for patches, if they need it: a view has
 * most patches, but few of their samples. */
#define PATCHES_PART (1.0 / 3.0)
/* And at most so much of what else the CPU's memory has room for. */
#define PATCHES_MIRROR_PART 0.5

/* Divides the room of both budgets: the shares of the scene's samples and of its patches. share: of
 * both, if they were the same. least: of both. */
static void divide(double shares[2], const demand *d, const double room[2], double share,
                   double least)
{
    const double patches = (double)d->patches * (double)sizeof(stp_gpu_patch);
    const double samples = (double)texture_bytes(d->samples, d->patches) - patches;
    const double more =
        fmin(SCENE_SHARE, fmin(PATCHES_PART * room[0] / patches,
                               PATCHES_MIRROR_PART * room[1] /
                                   ((double)d->patches * (double)PATCH_MIRROR_BYTES)));
    const double rest = (room[0] - more * patches) / samples;
    shares[0] = shares[1] = share;
    if (more <= share || rest < least)
        return;
    shares[0] = fmin(rest, share);
    shares[1] = more;
}

/* Makes room for the scene, or for as much of it as both budgets, and textures of so many texels,
 * hold. fixed: what else the budgets must hold. */
static stp_status plan_texture(stp_budget *b, const stp_scene *scene, const demand *d,
                               const uint64_t given[2], const uint64_t fixed[2], uint32_t texels,
                               stp_error *err)
{
    static const char *const names[2] = {"gpu", "cpu"};
    double least = fmin(1.0, 2.0 * fmax((double)d->most_samples / (double)d->samples,
                                        (double)d->most_patches / (double)d->patches));
    double whole[2] = {(double)texture_bytes(d->samples, d->patches),
                       (double)(d->patches * PATCH_MIRROR_BYTES)};
    uint64_t most_patches =
        smaller(texels / STP_OBJECT_TEXTURE_PATCH_TEXELS, STP_NAMED_PATCHES_LIMIT);
    const double most_texels = (double)stp_texels_most(d->samples, d->patches);
    const double fits[2] = {(double)texels / most_texels,
                            (double)most_patches / (double)d->patches};
    double share = SCENE_SHARE + least, room[2], shares[2];
    for (int i = 0; i < 2; i++) {
        room[i] = given[i] > fixed[i] ? (double)(given[i] - fixed[i]) : 0.0;
        double holds = room[i] / whole[i];
        if (holds < least)
            return refuse(scene, names[i], given[i], fixed[i] + (uint64_t)(least * whole[i]), err);
        share = fmin(share, holds);
    }
    if (fmin(fits[0], fits[1]) < least)
        return stp_error_set(err, STP_GL,
                             "%s: two blocks have more samples than a texture of this OpenGL (%u): "
                             "draw it on another GPU",
                             stp_chunk_file_path(scene->models[0].model->file), texels);
    divide(shares, d, room, share, least);
    b->slot_capacity = slots_of(scene);
    b->texel_capacity = (uint32_t)fmin(fmin(shares[0], fits[0]) * most_texels, UINT32_MAX - 1);
    b->patch_capacity =
        (uint32_t)fmin(fmin(shares[1], fits[1]) * (double)d->patches, UINT32_MAX - 1);
    b->gpu_bytes = fixed[0] + b->texel_capacity * (uint64_t)STP_TEXEL_BYTES +
                   b->patch_capacity * (uint64_t)sizeof(stp_gpu_patch);
    return STP_OK;
}

stp_status stp_budget_plan(stp_budget *out, const stp_scene *scene, const stp_budget_limits *limits,
                           stp_error *err)
{
    stp_budget b = {0};
    demand d = measure(scene);
    uint64_t given[2] = {limits->gpu_bytes != 0 ? limits->gpu_bytes : STP_BUDGET_DEFAULT_BYTES,
                         limits->cpu_bytes != 0 ? limits->cpu_bytes : STP_BUDGET_DEFAULT_BYTES};
    uint64_t piece = texture_bytes(d.most_samples, d.most_patches) + STP_PAYLOAD_UNIT_BYTES;
    b.ring_bytes = larger(piece, smaller(ring_most_bytes[limits->software], given[0] / 16));
    b.ring_bytes = smaller(b.ring_bytes, (scene->block_count + UINT64_C(1)) * piece);
    uint64_t decoding = DECODING_BLOCKS * d.most_decoded;
    b.decoder_count = choose_decoders(decoding, given[1], limits->decoders);
    uint64_t tables = scene->chunk_count * (uint64_t)sizeof(stp_chunk_entry) +
                      scene->block_count * (uint64_t)(sizeof(stp_block) + TABLE_BYTES);
    uint64_t decoded = b.decoder_count * decoding + tables;
    uint64_t least_payloads = smaller(PAYLOADS_LEAST * d.most_payload, d.payloads);
    const uint64_t fixed[2] = {b.ring_bytes + slots_of(scene) * (uint64_t)sizeof(stp_gpu_chunk),
                               decoded + least_payloads};
    stp_status status = plan_texture(&b, scene, &d, given, fixed, limits->texels, err);
    if (status != STP_OK)
        return status;
    uint64_t mirror = b.patch_capacity * (uint64_t)PATCH_MIRROR_BYTES;
    b.payload_bytes = smaller(given[1] - decoded - mirror, d.payloads);
    b.cpu_bytes = decoded + mirror + b.payload_bytes;
    *out = b;
    return STP_OK;
}
