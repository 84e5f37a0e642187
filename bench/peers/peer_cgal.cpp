// CGAL's Surface_mesh_approximation on a mesh: peer_cgal SCAN.off PROXIES random|hierarchical OUT.off OUT.labels. Writes its
// triangles and the region of each face, and prints its times, its peak of memory and whether its result is manifold, as JSON.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Variational_shape_approximation.h>

#include <array>
#include <ctime>
#include <fstream>
#include <iostream>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

namespace {

namespace VSA = CGAL::Surface_mesh_approximation;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;
using PointMap = boost::property_map<Surface, boost::vertex_point_t>::type;
using Approximation = CGAL::Variational_shape_approximation<Surface, PointMap>;

constexpr int kRounds = 20;

template <class Work>
double milliseconds(Work&& work) {
  const std::clock_t started = std::clock();
  work();
  return 1e3 * static_cast<double>(std::clock() - started) / CLOCKS_PER_SEC;
}

// The kernel's figure for this program; 0 where there is none.
long peak_bytes() {
  std::ifstream status("/proc/self/status");
  long kilobytes = 0;
  for (std::string word; status >> word;)
    if (word == "VmHWM:") status >> kilobytes;
  return 1024 * kilobytes;
}

}  // namespace

int main(int count, char** argument) {
  const long before = peak_bytes();
  Surface surface;
  if (count != 6 || !CGAL::IO::read_OFF(argument[1], surface)) return 2;
  const std::size_t proxies = std::stoul(argument[2]);
  const auto seeding = std::string(argument[3]) == "random" ? VSA::RANDOM : VSA::HIERARCHICAL;
  const auto points = get(boost::vertex_point, surface);
  const Approximation::Error_metric metric(surface, points);  // kept by address
  Approximation approximation(surface, points, metric);
  const double seeds = milliseconds([&] {
    approximation.initialize_seeds(CGAL::parameters::seeding_method(seeding).max_number_of_proxies(proxies));
  });
  const double rounds = milliseconds([&] { approximation.run(kRounds); });
  bool is_manifold = false;
  const double meshing =
      milliseconds([&] { is_manifold = approximation.extract_mesh(CGAL::parameters::all_default()); });
  std::cout << "{\"seeding_ms\": " << seeds << ", \"rounds_ms\": " << rounds << ", \"meshing_ms\": " << meshing
            << ", \"peak_bytes\": " << peak_bytes() - before << ", \"manifold\": " << std::boolalpha << is_manifold
            << "}\n";
  const auto map = surface.add_property_map<Surface::Face_index, std::size_t>("f:proxy", 0).first;
  approximation.proxy_map(map);
  std::ofstream labels(argument[5]);
  for (const Surface::Face_index f : surface.faces()) labels << map[f] << '\n';
  std::vector<Kernel::Point_3> corners;
  std::vector<std::array<std::size_t, 3>> triangles;
  approximation.output(CGAL::parameters::anchors(std::back_inserter(corners)).triangles(std::back_inserter(triangles)));
  std::ofstream file(argument[4]);
  file.precision(std::numeric_limits<double>::max_digits10);
  file << "OFF\n" << corners.size() << ' ' << triangles.size() << " 0\n";
  for (const Kernel::Point_3& p : corners) file << p << '\n';
  for (const auto& t : triangles) file << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  return file && labels ? 0 : 3;
}
