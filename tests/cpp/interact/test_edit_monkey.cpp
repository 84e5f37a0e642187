#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "edit_monkey.h"
#include "isimp/mesh/clean.h"
#include "isimp/mesh/io.h"
#include "labelled.h"
#include "shapes.h"

/// Every edit at some faces of partitions of every kind. Unlike bench/monkeys/monkey.py it sees the sums of regions, and
/// runs in every build of the C++ tests, with sanitizers too.
namespace isimp {
namespace {

monkey::Settings few(std::uint32_t seed) {
  return {.seed = seed, .random_regions = 5, .faces_of_region = 2, .random_faces = 10, .chains = 1, .chain = 10};
}

TEST(EditMonkey, GeneratedShapes) {
  const shapes::Arrays bumps = shapes::noisy(shapes::sphere(3), 0.02, 5);
  const shapes::Arrays all[] = {bumps, shapes::noisy(shapes::torus(24, 12), 0.03, 1), shapes::plane(8),
                                shapes::both(shapes::cube(4), shapes::noisy(shapes::sphere(2), 0.1, 3), {2, 0, 0})};
  monkey::Tally tally;
  std::uint32_t seed = 0;
  for (const shapes::Arrays& arrays : all) {
    ++seed;
    monkey::run_all(shapes::mesh(arrays), "shape " + std::to_string(seed), {0.02, 0.005}, true, few(seed), tally);
  }
  EXPECT_EQ(tally.findings, std::vector<std::string>());
  EXPECT_GT(tally.actions(), 1000);
  EXPECT_GT(tally.small_pieces, 0);
}

TEST(EditMonkey, Scans) {
  const std::string folder = labelled::data_folder();
  if (folder.empty()) GTEST_SKIP() << "no test data: set ISIMP_DATA";
  monkey::Tally tally;
  for (const char* name : {"scan/rockerarm_20k.ply", "building/frankfurt_tile_49k.ply"}) {
    Job job;
    const PolygonSoup soup = read_polygons(std::filesystem::path(folder) / name, job);
    const Mesh mesh = clean(soup.vertices, triangulate(soup, job).triangles, {}, job);
    monkey::Settings settings = few(1);
    settings.polygonize = false;
    monkey::run_all(mesh, name, {0.005}, false, settings, tally);
  }
  EXPECT_EQ(tally.findings, std::vector<std::string>());
}

}  // namespace
}  // namespace isimp
