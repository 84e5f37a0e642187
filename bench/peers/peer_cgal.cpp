// CGAL's Surface_mesh_approximation on the same mesh, judged by the same measure, with rounds of the plain reference
// in between so that its times can be set in relation to the engine's. Prints JSON; writes its triangles where asked.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Variational_shape_approximation.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <iostream>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "evaluate.h"
#include "input.h"
#include "isimp/core/errors.h"
#include "measure.h"
#include "reference.h"

namespace isimp::bench {
namespace {

namespace VSA = CGAL::Surface_mesh_approximation;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;
using PointMap = boost::property_map<Surface, boost::vertex_point_t>::type;
using Approximation = CGAL::Variational_shape_approximation<Surface, PointMap>;
using FaceMap = Surface::Property_map<Surface::Face_index, std::size_t>;

constexpr int kRounds = 20;

Surface to_cgal(const Mesh& mesh) {
  Surface surface;
  for (const Vec3& v : mesh.vertices()) surface.add_vertex({v.x(), v.y(), v.z()});
  const auto at = [](std::int32_t v) { return Surface::Vertex_index(static_cast<Surface::size_type>(v)); };
  for (const Triangle& t : mesh.triangles())
    if (surface.add_face(at(t[0]), at(t[1]), at(t[2])) == Surface::null_face())
      throw InvalidInput("CGAL refuses a face of this mesh");
  return surface;
}

Json json_of(const Lap& lap) {
  Json json;
  json["cpu_ms"] = lap.cpu_ms;
  json["wall_ms"] = lap.wall_ms;
  return json;
}

void write_off(Approximation& approximation, const std::string& path) {
  std::vector<Kernel::Point_3> points;
  std::vector<std::array<std::size_t, 3>> triangles;
  approximation.output(CGAL::parameters::anchors(std::back_inserter(points)).triangles(std::back_inserter(triangles)));
  std::ofstream file(path);
  file.precision(std::numeric_limits<double>::max_digits10);
  file << "OFF\n" << points.size() << ' ' << triangles.size() << " 0\n";
  for (const Kernel::Point_3& p : points) file << p << '\n';
  for (const auto& t : triangles) file << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  file.close();
  if (!file) throw FileError("cannot write " + path);
}

Json approximate(const Mesh& mesh, const PlainSurface& plain, std::int32_t proxies, VSA::Seeding_method seeding,
                 const std::string& off) {
  Json json;
  const MemoryGauge gauge;
  Surface surface = to_cgal(mesh);
  const auto points = get(boost::vertex_point, surface);
  const Approximation::Error_metric metric(surface, points);  // kept by address
  Approximation approximation(surface, points, metric);
  json["seeding"] = json_of(timed([&] {
    approximation.initialize_seeds(
        CGAL::parameters::seeding_method(seeding).max_number_of_proxies(static_cast<std::size_t>(proxies)));
  }));
  json["reference_round_ms"] = reference(plain, {.proxies = proxies, .rounds = 3}).round_ms;
  json["rounds"] = json_of(timed([&] { approximation.run(kRounds); }));
  std::vector<std::int32_t> label(plain.area.size());
  const FaceMap map = surface.add_property_map<Surface::Face_index, std::size_t>("f:proxy", 0).first;
  approximation.proxy_map(map);
  for (const Surface::Face_index f : surface.faces()) label[f.idx()] = static_cast<std::int32_t>(map[f]);
  json["meshing"] =
      json_of(timed([&] { json["manifold"] = approximation.extract_mesh(CGAL::parameters::all_default()); }));
  json["peak_bytes"] = gauge.peak();
  if (!off.empty()) write_off(approximation, off);
  json["result"] = to_json(evaluate(mesh, plain, label));
  return json;
}

int run(int argc, char** argv) {
  if (argc < 5 || argc > 6 || (std::string(argv[4]) != "random" && std::string(argv[4]) != "hierarchical"))
    throw InvalidInput("peer_cgal INPUT LOOP PROXIES random|hierarchical [OUT.off]");
  const Arrays arrays = load_input(argv[1], std::stoi(argv[2]));
  Job job;
  const Mesh mesh(arrays.vertices, arrays.triangles, job);
  const auto seeding = std::string(argv[4]) == "random" ? VSA::RANDOM : VSA::HIERARCHICAL;
  std::cout << approximate(mesh, plain_surface(mesh), std::stoi(argv[3]), seeding, argc == 6 ? argv[5] : "") << '\n';
  return 0;
}

}  // namespace
}  // namespace isimp::bench

int main(int argc, char** argv) {
  try {
    return isimp::bench::run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 2;
  }
}
