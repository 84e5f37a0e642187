#include <algorithm>
#include <optional>
#include <utility>

#include "cases.h"
#include "isimp/mesh/io.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/simplify/partitioner.h"

namespace isimp::bench {
namespace {

/// Runs the phases one after another and notes of each what it took.
class Phases {
 public:
  Phases() : first_(gauge_now()) {}

  template <class Work>
  void run(const std::string& name, Work&& work) {
    const MemoryGauge gauge;
    const Lap lap = timed(std::forward<Work>(work));
    Json phase;
    phase["cpu_ms"] = lap.cpu_ms;
    phase["wall_ms"] = lap.wall_ms;
    phase["before_bytes"] = gauge.before() - first_;
    phase["peak_bytes"] = gauge.before() + gauge.peak() - first_;
    all_["phases"][name] = phase;
    peak_ = std::max(peak_, gauge.before() + gauge.peak() - first_);
    wall_ms_ += lap.wall_ms;
  }

  Json finish(std::int64_t array_bytes) {
    all_["array_bytes"] = array_bytes;
    all_["peak_bytes"] = peak_;
    all_["wall_ms"] = wall_ms_;
    return all_;
  }

 private:
  static std::int64_t gauge_now() { return MemoryGauge().before(); }

  std::int64_t first_, peak_ = 0;
  double wall_ms_ = 0.0;
  Json all_;
};

}  // namespace

Json whole_way(const std::string& input, std::int32_t loop, std::int32_t proxies, const std::string& scratch) {
  Phases phases;
  Arrays arrays;
  phases.run("read", [&] { arrays = load_input(input, loop); });
  const auto array_bytes =
      static_cast<std::int64_t>(arrays.vertices.size() * sizeof(Vec3) + arrays.triangles.size() * sizeof(Triangle));
  std::optional<Mesh> mesh;
  Job job;
  phases.run("mesh", [&] { mesh.emplace(std::move(arrays.vertices), std::move(arrays.triangles), job); });
  PartitionOptions options;
  options.proxies = std::min(proxies, mesh->face_count());
  options.threads = 1;
  Partition regions;
  phases.run("partition", [&] { regions = partition(*mesh, options, job); });
  PolygonMesh polygons;
  phases.run("polygonize", [&] { polygons = polygonize(*mesh, regions, {.threads = 1}, job); });
  phases.run("write", [&] {
    write_polygons(scratch + "/whole_way.ply", polygons.vertices, polygons.loops, polygons.loop_start, job);
  });
  return phases.finish(array_bytes);
}

}  // namespace isimp::bench
