/* CGAL::pca_estimate_normals behind a C function. */
#include <CGAL/Simple_cartesian.h>
#include <CGAL/pca_estimate_normals.h>
#include <CGAL/property_map.h>

#include <utility>
#include <vector>

#include "tools/bench/cgal/cgal_shim.h"

typedef CGAL::Simple_cartesian<double> kernel;
typedef std::pair<kernel::Point_3, kernel::Vector_3> oriented;

int cgal_pca_normals(const double (*positions)[3], size_t count, unsigned k, double (*normals)[3])
{
    try {
        std::vector<oriented> points(count);
        for (size_t i = 0; i < count; i++)
            points[i].first = kernel::Point_3(positions[i][0], positions[i][1], positions[i][2]);
        CGAL::pca_estimate_normals<CGAL::Parallel_if_available_tag>(
            points, k,
            CGAL::parameters::point_map(CGAL::First_of_pair_property_map<oriented>())
                .normal_map(CGAL::Second_of_pair_property_map<oriented>()));
        for (size_t i = 0; i < count; i++)
            for (int axis = 0; axis < 3; axis++)
                normals[i][axis] = points[i].second[axis];
        return 0;
    } catch (...) {
        return -1;
    }
}
