// Kinetic surface reconstruction (CGAL 6 and later) of points with normals. Prints the number of planar shapes; writes
// its polygons as OBJ. bench/quality/buildings.py compiles and runs it: peer_ksr POINTS.ply OUT.obj DISTANCE ANGLE LEAST LAMBDA
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Kinetic_surface_reconstruction_3.h>
#include <CGAL/Point_set_3.h>
#include <CGAL/Point_set_3/IO.h>

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <vector>

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Points = CGAL::Point_set_3<Kernel::Point_3>;
using Reconstruction = CGAL::Kinetic_surface_reconstruction_3<Kernel, Points, Points::Point_map, Points::Vector_map>;

constexpr std::size_t kAtOnce = 2;  // planes that a polygon grows through; more give more cells
constexpr int kSides = 6;           // sides of the box around the scan, which are outside

}  // namespace

int main(int count, char** argument) {
  Points points;
  if (count != 7 || !CGAL::IO::read_point_set(argument[1], points)) return 2;
  const double distance = std::atof(argument[3]);
  const auto options = CGAL::parameters::maximum_distance(distance)
                           .maximum_angle(std::atof(argument[4]))
                           .minimum_region_size(static_cast<std::size_t>(std::atoi(argument[5])))
                           .maximum_offset(distance)
                           .reorient_bbox(true);
  Reconstruction ksr(points, options);
  ksr.detection_and_partition(kAtOnce, options);
  std::vector<Kernel::Point_3> vertices;
  std::vector<std::vector<std::size_t>> polygons;
  std::map<Reconstruction::KSP::Face_support, bool> is_inside;
  for (int side = -kSides; side < 0; ++side) is_inside[static_cast<Reconstruction::KSP::Face_support>(side)] = false;
  ksr.reconstruct(std::atof(argument[6]), is_inside, std::back_inserter(vertices), std::back_inserter(polygons));
  std::cout << ksr.detected_planar_shapes().size() << "\n";
  std::ofstream out(argument[2]);
  out.precision(17);
  for (const auto& v : vertices) out << "v " << v << "\n";
  for (const auto& polygon : polygons) {
    out << "f";
    for (const std::size_t v : polygon) out << " " << v + 1;
    out << "\n";
  }
  return out ? 0 : 1;
}
