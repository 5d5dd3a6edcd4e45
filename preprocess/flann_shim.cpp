/* FLANN's exact single kd-tree over 3D float points, as C. */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wshadow"
#include <flann/flann.hpp>
#pragma GCC diagnostic pop

extern "C" {
#include "preprocess/flann_shim.h"
}

#include <memory>

namespace
{
typedef flann::L2_3D<float> metric;
typedef flann::KDTreeSingleIndex<metric> index_type;
} // namespace

struct stp_kd_tree {
    index_type index;

    stp_kd_tree(float *points, size_t count)
        : index(flann::Matrix<float>(points, count, 3), flann::KDTreeSingleIndexParams(12))
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

extern "C" int stp_kd_tree_nearest(const stp_kd_tree *tree, const float query[3], int k,
                                   int32_t *indices, float *squared_distances)
{
    try {
        flann::KNNSimpleResultSet<float> found(static_cast<size_t>(k));
        size_t ids[128];
        if (k > 128)
            return -1;
        tree->index.findNeighbors(found, query, flann::SearchParams(-1));
        size_t count = std::min(found.size(), static_cast<size_t>(k));
        found.copy(ids, squared_distances, count);
        for (size_t i = 0; i < count; i++)
            indices[i] = static_cast<int32_t>(ids[i]);
        return static_cast<int>(count);
    } catch (...) {
        return -1;
    }
}
