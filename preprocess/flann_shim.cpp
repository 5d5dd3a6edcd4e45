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

#include <limits>
#include <memory>

namespace
{
typedef flann::L2_3D<float> metric;
typedef flann::KDTreeSingleIndex<metric> index_type;
} // namespace

struct stp_kd_tree {
    index_type index;

    stp_kd_tree(float *points, size_t count)
        : index(flann::Matrix<float>(points, count, 3), flann::KDTreeSingleIndexParams(10))
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

extern "C" bool stp_kd_tree_nearest(const stp_kd_tree *tree, const float *queries,
                                    size_t query_count, size_t k, uint32_t *indices, float *squared)
{
    try {
        flann::KNNSimpleResultSet<float> found(k);
        std::vector<size_t> places(k);
        const flann::SearchParams exact(flann::FLANN_CHECKS_UNLIMITED);
        for (size_t q = 0; q < query_count; q++, indices += k, squared += k) {
            found.clear();
            tree->index.findNeighbors(found, queries + 3 * q, exact);
            found.copy(places.data(), squared, k);
            for (size_t i = 0; i < k; i++) {
                bool here = i < found.size();
                indices[i] = here ? static_cast<uint32_t>(places[i]) : STP_KD_TREE_NONE;
                squared[i] = here ? squared[i] : std::numeric_limits<float>::infinity();
            }
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
        flann::RadiusResultSet<float> found(squared);
        tree->index.findNeighbors(found, query, flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
        std::vector<size_t> places(found.size());
        std::vector<float> distances(found.size());
        found.copy(places.data(), distances.data(), places.size(), false);
        for (size_t i = 0; i < places.size(); i++)
            indices[i] = static_cast<uint32_t>(places[i]);
        *count = places.size();
        return true;
    } catch (...) {
        return false;
    }
}
