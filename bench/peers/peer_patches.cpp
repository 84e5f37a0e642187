// Polygons by CGAL's remesh_almost_planar_patches (6 and later): planes by region growing, corners where regions meet.
// bench/peers/patches.py compiles and runs it: peer_patches SCAN.off OUT.off DISTANCE COSINE. Prints the number of regions.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/IO/polygon_mesh_io.h>
#include <CGAL/Polygon_mesh_processing/region_growing.h>
#include <CGAL/Polygon_mesh_processing/remesh_planar_patches.h>
#include <CGAL/Surface_mesh.h>

#include <boost/property_map/vector_property_map.hpp>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <vector>

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
namespace pmp = CGAL::Polygon_mesh_processing;

template <class T>
auto map_of(std::vector<T>& values) {
  return CGAL::make_random_access_property_map(values);
}

}  // namespace

int main(int count, char** argument) {
  Mesh scan;
  if (count != 5 || !pmp::IO::read_polygon_mesh(argument[1], scan)) return 2;
  const double distance = std::atof(argument[3]);
  const double cosine = std::atof(argument[4]);
  std::vector<std::size_t> region(num_faces(scan));
  std::vector<std::size_t> corner(num_vertices(scan), std::numeric_limits<std::size_t>::max());
  std::vector<bool> border(num_edges(scan), false);
  boost::vector_property_map<Kernel::Vector_3> normal;
  const auto limits = CGAL::parameters::cosine_of_maximum_angle(cosine).maximum_distance(distance);
  const std::size_t regions =
      pmp::region_growing_of_planes_on_faces(scan, map_of(region), limits.region_primitive_map(normal));
  const std::size_t corners = pmp::detect_corners_of_regions(scan, map_of(region), regions, map_of(corner),
                                                             limits.edge_is_constrained_map(map_of(border)));
  Mesh made;
  pmp::remesh_almost_planar_patches(scan, made, regions, corners, map_of(region), map_of(corner), map_of(border),
                                    CGAL::parameters::patch_normal_map(normal),
                                    CGAL::parameters::do_not_triangulate_faces(true));
  std::cout << regions << '\n';
  return CGAL::IO::write_polygon_mesh(argument[2], made, CGAL::parameters::stream_precision(17)) ? 0 : 3;
}
