/* FLANN's exact single kd-tree over 3D float points, as C. */
#include <limits>
#include <memory>
#include <new>
#include <stdlib.h>

/* If memory runs out, FLANN's pool prints a message and goes on with NULL. So FLANN gets this
 * malloc, which throws; the entries below catch. */
static inline void *stp_flann_malloc(size_t size)
{
    void *memory = malloc(size);
    if (!memory)
        throw std::bad_alloc();
    return memory;
}
#define malloc stp_flann_malloc
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wshadow"
#include <flann/flann.hpp>
#pragma GCC diagnostic pop
#undef malloc

extern "C" {
#include "preprocess/cloud/flann_shim.h"
}

namespace
{
typedef flann::L2_3D<float> metric;
typedef flann::KDTreeSingleIndex<metric> index_type;

/* Points in a leaf. Smaller leaves take longer to build than they save in searches for a group. */
const int leaf_points = 32;

/* Collects every point nearer than a distance in the caller's memory. */
class collector : public flann::ResultSet<float>
{
  public:
    collector(float squared, uint32_t *indices) : squared_(squared), begin_(indices), end_(indices)
    {
    }
    bool full() const override
    {
        return true;
    }
    void addPoint(float squared, size_t index) override
    {
        if (squared < squared_)
            *end_++ = static_cast<uint32_t>(index);
    }
    float worstDist() const override
    {
        return squared_;
    }
    size_t size() const
    {
        return static_cast<size_t>(end_ - begin_);
    }

  private:
    float squared_;
    uint32_t *begin_;
    uint32_t *end_;
};
} // namespace

struct stp_kd_tree {
    index_type index;

    stp_kd_tree(float *points, size_t count)
        : index(flann::Matrix<float>(points, count, 3), flann::KDTreeSingleIndexParams(leaf_points))
    {
        index.buildIndex();
    }
};

extern "C" stp_kd_tree *stp_kd_tree_create(float *points, size_t count)
{
    try {
        return std::make_unique<stp_kd_tree>(points, count).release();
    } catch (...) {
        return nullptr;
    }
}

extern "C" void stp_kd_tree_destroy(stp_kd_tree *tree)
{
    delete tree;
}

extern "C" bool stp_kd_tree_nearest(const stp_kd_tree *tree, const float query[3], size_t k,
                                    uint32_t *indices, float *squared)
{
    try {
        flann::KNNSimpleResultSet<float> found(k);
        std::vector<size_t> places(k);
        tree->index.findNeighbors(found, query, flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
        found.copy(places.data(), squared, k);
        for (size_t i = 0; i < k; i++) {
            bool here = i < found.size();
            indices[i] = here ? static_cast<uint32_t>(places[i]) : STP_KD_TREE_NONE;
            squared[i] = here ? squared[i] : std::numeric_limits<float>::infinity();
        }
        return true;
    } catch (...) {
        return false;
    }
}

extern "C" bool stp_kd_tree_within(const stp_kd_tree *tree, const float query[3], float squared,
                                   uint32_t *indices, size_t *count)
{
    try {
        collector found(squared, indices);
        tree->index.findNeighbors(found, query, flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
        *count = found.size();
        return true;
    } catch (...) {
        return false;
    }
}
