/* The attributes of what was clicked, and which sample of a grid it is. */
#include "tools/view/view_values.h"

#include "base/memory.h"
#include "formats/chunk/attribute/attribute_file.h"
#include "formats/chunk/codec/square/square.h"
#include "runtime/cut/model.h"
#include "runtime/stream/chosen.h"

#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>

/* Marks the samples of a whole chunk that the model does not draw. */
static stp_status mark(const stp_model *model, stp_chunk *chunk)
{
    const stp_block whole = stp_block_of_entry(&model->entries[chunk->id], chunk->id);
    const stp_numbers_block block = {&whole, 0, 1, chunk};
    return model->chosen ? stp_chosen_mark(model->chosen, &block, chunk, NULL) : STP_OK;
}

/* The level-0 sample of the chunk that is drawn and nearest to a position; UINT32_MAX if there is
 * none. chosen: samples may be marked as not drawn. */
static uint32_t nearest_sample(const stp_chunk *chunk, bool chosen, stp_dvec3 at)
{
    uint32_t best = UINT32_MAX;
    double least = INFINITY;
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (uint32_t i = chunk->level_begin[0][p]; i < chunk->level_begin[0][p + 1]; i++) {
            const stp_sample *s = &chunk->samples[0][i];
            const stp_dvec3 d = stp_dvec3_sub(stp_sample_position(s, &chunk->patches[p]), at);
            const double square = chosen && stp_sample_marked(s) ? INFINITY : stp_dvec3_dot(d, d);
            best = square < least ? i : best;
            least = fmin(least, square);
        }
    return best;
}

static stp_status read_values(view_values *out, stp_attribute_file *file, const stp_chunk *chunk,
                              uint32_t sample)
{
    stp_status status = STP_OK;
    const stp_attribute_list *list = stp_attribute_file_list(file);
    uint64_t *words = NULL;
    STP_TRY(stp_alloc(&words, chunk->level_begin[0][chunk->patch_count], sizeof *words,
                      "attributes", NULL));
    for (uint32_t a = 0; a < list->count; a++) {
        STP_TRY(stp_attribute_file_read(file, a, chunk, 0, words, NULL));
        memcpy(out->names[a], list->items[a].name, sizeof out->names[a]);
        out->values[a] = stp_attribute_value(&list->items[a], words[sample]);
    }
    out->count = list->count;
done:
    free(words);
    return status;
}

/* What a chunk has at a place of a raster and around it. */
typedef struct neighbourhood {
    int64_t least[2], most[2]; /* of all the raster's squares in the chunk, in squares */
    bool has[9];               /* samples, row by row; the place itself is number 4 */
} neighbourhood;

/* The column (k = 0) or row of number i around a place. */
static int64_t beside(int i, const int64_t at[2], int k)
{
    return at[k] + (k == 0 ? i % 3 : i / 3) - 1;
}

/* Blocks have rasters of their own, which are one if their numbers are. */
static bool is_same(const stp_raster *a, const stp_raster *b)
{
    bool same = a->axis == b->axis;
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 6; i++)
            same = same && a->across[k][i] == b->across[k][i];
    return same;
}

static neighbourhood look_around(const stp_chunk *chunk, uint32_t raster, const int64_t at[2])
{
    neighbourhood out = {.least = {INT64_MAX, INT64_MAX}, .most = {-1, -1}};
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_square *square = &chunk->squares[p];
        const int64_t of[2] = {square->column, square->row};
        if (!square->samples || !is_same(&chunk->rasters[square->raster], &chunk->rasters[raster]))
            continue;
        for (int k = 0; k < 2; k++) {
            out.least[k] = of[k] < out.least[k] ? of[k] : out.least[k];
            out.most[k] = of[k] > out.most[k] ? of[k] : out.most[k];
        }
        for (int i = 0; i < 9; i++) {
            const int64_t column = beside(i, at, 0), row = beside(i, at, 1);
            const uint32_t place = stp_square_morton((uint32_t)column & 7u, (uint32_t)row & 7u);
            if (column >> 3 == of[0] && row >> 3 == of[1] && square->samples >> place & 1u)
                out.has[i] = true;
        }
    }
    return out;
}

/* Counts the places around one at which the chunk would have samples, as far as its squares tell,
 * and those that are missing. */
static void count_neighbours(view_grid_sample *out, const stp_chunk *chunk, uint32_t raster)
{
    const int64_t at[2] = {out->column, out->row};
    const neighbourhood n = look_around(chunk, raster, at);
    for (int i = 0; i < 9; i++) {
        bool told = i != 4;
        for (int k = 0; k < 2; k++) {
            const int64_t square = beside(i, at, k) >> 3;
            told = told && square >= n.least[k] && square <= n.most[k];
        }
        out->told += told ? 1u : 0u;
        out->missing += told && !n.has[i] ? 1u : 0u;
    }
}

/* Whether squares of depth images have the images' rows as columns. False if the file does not say
 * which. */
static bool find_turned(bool *out, const stp_model *model)
{
    const stp_chunk_file_info *info = model->info;
    cJSON *root = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const cJSON *turned = cJSON_GetObjectItemCaseSensitive(root, "turned");
    const bool told = cJSON_IsBool(turned);
    *out = told && cJSON_IsTrue(turned);
    cJSON_Delete(root);
    return told;
}

/* The depth of a position in a camera's image: its distance from where the rays meet, along the
 * axis. */
static double depth_of(const stp_raster *raster, stp_dvec3 at)
{
    const double along[3] = {at.x, at.y, at.z};
    double by = 0.0, apart = 0.0; /* what lies a column or row apart: apart + by * place */
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 2; i++)
            if (fabs(raster->across[k][4 + i]) > fabs(by)) {
                by = raster->across[k][4 + i];
                apart = raster->across[k][1 + i];
            }
    return fabs(along[raster->axis] + apart / by);
}

/* Finds the place in its grid of a level-0 sample. */
static void find_in_grid(view_grid_sample *out, const stp_model *model, const stp_chunk *chunk,
                         double origin_z, uint32_t sample)
{
    uint32_t p = 0;
    while (chunk->level_begin[0][p + 1] <= sample)
        p++;
    const stp_square *square = chunk->squares ? &chunk->squares[p] : NULL;
    if (!square || !square->samples)
        return;
    const stp_raster *raster = &chunk->rasters[square->raster];
    const bool is_depth = stp_raster_spreads(raster);
    bool turned = false;
    if (is_depth ? !find_turned(&turned, model) : !raster->level)
        return;
    uint64_t left = square->samples;
    for (uint32_t i = chunk->level_begin[0][p]; i < sample; i++)
        left &= left - 1;
    const uint32_t place = (uint32_t)__builtin_ctzll(left);
    const stp_dvec3 at = stp_sample_position(&chunk->samples[0][sample], &chunk->patches[p]);
    *out = (view_grid_sample){.known = true,
                              .column = square->column * STP_SQUARE_SIDE + stp_square_column(place),
                              .row = square->row * STP_SQUARE_SIDE + stp_square_row(place),
                              .is_depth = is_depth,
                              .height = is_depth ? depth_of(raster, at) : origin_z + at.z};
    count_neighbours(out, chunk, square->raster);
    if (turned) {
        const uint32_t column = out->row;
        out->row = out->column;
        out->column = column;
    }
}

void view_values_find(view_values *out, const stp_model *model, const stp_pick *pick)
{
    stp_attribute_file *file = NULL;
    stp_chunk *chunk = NULL;
    out->count = 0;
    out->grid.known = false;
    if (!pick->hit || pick->chunk >= model->info->chunk_count)
        return;
    if (stp_chunk_file_read(model->file, pick->chunk, 0, &chunk, NULL) == STP_OK &&
        mark(model, chunk) == STP_OK) {
        const stp_dvec3 origin = model->entries[pick->chunk].origin;
        const uint32_t sample =
            nearest_sample(chunk, model->chosen != NULL, stp_dvec3_sub(pick->position, origin));
        if (sample != UINT32_MAX && stp_attribute_file_open(&file, model->file, NULL) == STP_OK)
            (void)read_values(out, file, chunk, sample);
        if (sample != UINT32_MAX && pick->level == 0)
            find_in_grid(&out->grid, model, chunk, origin.z, sample);
    }
    stp_chunk_destroy(&chunk);
    stp_attribute_file_close(&file);
}
