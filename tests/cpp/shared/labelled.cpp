#include "labelled.h"

#include <cstdlib>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "tests.h"

namespace isimp::labelled {

Partition by(std::vector<std::int32_t> regions) {
  Partition p;
  std::int32_t most = kNone;
  for (const std::int32_t r : regions) most = std::max(most, r);
  p.region_seed.assign(most + 1, 0);
  p.region_normal.assign(most + 1, Vec3::Zero());
  for (std::size_t f = 0; f < regions.size(); ++f)
    if (regions[f] != kNone) p.region_seed[regions[f]] = static_cast<std::int32_t>(f);
  p.face_region = std::move(regions);
  p.proxies_asked = p.region_count();
  return p;
}

Partition planes(const Mesh& mesh) {
  std::map<std::array<std::int64_t, 4>, std::int32_t> known;
  std::vector<std::int32_t> regions;
  for (const Triangle& t : mesh.triangles()) {
    const Vec3 &a = mesh.vertices()[t[0]], &b = mesh.vertices()[t[1]], &c = mesh.vertices()[t[2]];
    const Vec3 n = (b - a).cross(c - a).normalized() * 1e4;
    const std::array<std::int64_t, 4> key{std::llround(n.x()), std::llround(n.y()), std::llround(n.z()),
                                          std::llround(n.dot(a))};
    regions.push_back(known.emplace(key, static_cast<std::int32_t>(known.size())).first->second);
  }
  return by(std::move(regions));
}

Partition voronoi(const Mesh& mesh, int count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<std::int32_t> faces(mesh.face_count()), regions(mesh.face_count(), kNone);
  std::iota(faces.begin(), faces.end(), 0);
  std::vector<std::int32_t> taken(mesh.component_count(), 0);
  std::shuffle(faces.begin(), faces.end(), random);
  std::deque<std::int32_t> queue;
  std::int32_t next = 0;
  for (const std::int32_t f : faces) {  // the first of each component, then any others
    if (next >= count && taken[mesh.component()[f]] > 0) continue;
    ++taken[mesh.component()[f]];
    regions[f] = next++;
    queue.push_back(f);
  }
  while (!queue.empty()) {
    const std::int32_t f = queue.front();
    queue.pop_front();
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
      const std::int32_t o = mesh.opposite(h);
      if (o == kNone || regions[o / 3] != kNone) continue;
      regions[o / 3] = regions[f];
      queue.push_back(o / 3);
    }
  }
  return by(std::move(regions));
}

Partition noise(const Mesh& mesh, int count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<std::int32_t> regions(mesh.face_count());
  for (std::int32_t& r : regions) r = static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(count));
  for (std::int32_t r = 0; r < count && r < mesh.face_count(); ++r) regions[r] = r;
  return by(std::move(regions));
}

Partition single(const Mesh& mesh) { return by(std::vector<std::int32_t>(mesh.face_count(), 0)); }

Partition each(const Mesh& mesh) {
  std::vector<std::int32_t> regions(mesh.face_count());
  std::iota(regions.begin(), regions.end(), 0);
  return by(std::move(regions));
}

PolygonMesh meshed(const Mesh& mesh, const Partition& partition, const MeshingOptions& options) {
  return polygonize(mesh, partition, options, job());
}

std::string data_folder() {
  namespace fs = std::filesystem;
  if (const char* set = std::getenv("ISIMP_DATA")) return set;
  const fs::path beside = fs::path(ISIMP_SOURCE_DIR) / ".." / "shared" / "data";
  return fs::exists(beside) ? beside.string() : "";
}

Partition read_labels(const std::string& path) {
  std::ifstream in(path);
  std::vector<std::int32_t> regions;
  for (std::int32_t r = 0; in >> r;) regions.push_back(r);
  return by(std::move(regions));
}

}  // namespace isimp::labelled
