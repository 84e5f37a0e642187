// Times the way from file to file, with its peak of memory.
#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "cases.h"
#include "isimp/mesh/io.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/simplify/partitioner.h"

namespace isimp::bench {
namespace {

/// Runs the phases one after another and records the time and memory of each.
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

/// The least time in which one thread and two read a mesh as binary PLY, in turn.
Json read_on_threads(const Mesh& mesh, const std::string& scratch) {
  const std::string path = scratch + "/read_on_threads.ply";
  std::vector<std::int32_t> loops, starts;
  for (const Triangle& t : mesh.triangles()) {
    starts.push_back(static_cast<std::int32_t>(loops.size()));
    loops.insert(loops.end(), t.begin(), t.end());
  }
  Job job;
  write_polygons(path, mesh.vertices(), loops, starts, job);
  constexpr int kRounds = 5;
  std::array<Lap, 2> least;
  for (int round = 0; round < kRounds; ++round)
    for (const std::int32_t threads : {1, 2}) {
      const Lap lap = timed([&] { read_polygons(path, job, threads); });
      Lap& best = least[static_cast<std::size_t>(threads - 1)];
      best.cpu_ms = round == 0 ? lap.cpu_ms : std::min(best.cpu_ms, lap.cpu_ms);
      best.wall_ms = round == 0 ? lap.wall_ms : std::min(best.wall_ms, lap.wall_ms);
    }
  std::filesystem::remove(path);
  Json all;
  for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
    Json& times = all[k == 0 ? "one" : "two"];
    times["cpu_ms"] = least[k].cpu_ms;
    times["wall_ms"] = least[k].wall_ms;
  }
  return all;
}

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
  Json all = phases.finish(array_bytes);
  all["read_on_threads"] = read_on_threads(*mesh, scratch);
  return all;
}

}  // namespace isimp::bench
