// Cohen-Steiner, Alliez, Desbrun: Variational Shape Approximation, 2004.

#include "isimp/partition/partition.h"

#include <sstream>
#include <utility>

#include "isimp/core/errors.h"
#include "isimp/partition/lloyd.h"
#include "isimp/partition/parts.h"
#include "isimp/partition/regions.h"
#include "isimp/partition/seeding.h"

namespace isimp {
namespace {

template <class T>
[[noreturn]] void out_of_range(const char* name, const std::string& range, T value) {
  std::ostringstream text;
  text << name << " must be " << range << ", got " << value;
  throw InvalidInput(text.str());
}

void check(const Mesh& mesh, const PartitionOptions& options) {
  if (options.proxies < 1 || options.proxies > mesh.face_count())
    out_of_range("proxies", "in [1, " + std::to_string(mesh.face_count()) + "]", options.proxies);
  if (!(options.leave_out >= 0 && options.leave_out < 1)) out_of_range("leave_out", "in [0, 1)", options.leave_out);
  if (options.iterations < 1) out_of_range("iterations", "at least 1", options.iterations);
  if (options.threads < 0) out_of_range("threads", "at least 0", options.threads);
  if (options.backend != "cpu") throw InvalidInput("there is no backend \"" + options.backend + "\"; there is \"cpu\"");
}

std::vector<std::int32_t> first_seeds(const Mesh& mesh, const Parts& parts, const PartitionOptions& options, Job& job) {
  Job::Part stage(job, "seeding", 0.0, 0.1);
  const std::vector<std::int32_t> share = share_out(parts);
  switch (options.seeding) {
    case Seeding::random:
      return random_seeds(mesh, parts, share, options.seed, job);
    case Seeding::farthest:
      return farthest_seeds(mesh, parts, share, options.seed, job);
  }
  throw InvalidInput("the seeding is none of those known");
}

Partition make_partition(const Mesh& mesh, const Parts& parts, const Regions& regions, std::vector<double> history,
                         Job& job) {
  const FaceGraph& graph = mesh.graph();
  Partition result;
  result.face_region.resize(static_cast<std::size_t>(graph.size()));
  for (std::int32_t i = 0; i < graph.size(); ++i) result.face_region[graph.mesh_face[i]] = regions.label[i];
  result.region_seed = nearest_faces(graph, regions, job);
  for (std::int32_t& seed : result.region_seed) seed = graph.mesh_face[seed];
  result.region_normal.reserve(regions.sum.size());
  for (const RegionSum& s : regions.sum) result.region_normal.push_back(s.normal());
  result.region_sum = regions.sum;
  result.error = regions.error() * graph.area;
  result.history = std::move(history);
  for (double& error : result.history) error *= graph.area;
  result.proxies_asked = parts.asked;
  result.proxies_needed = parts.needed;
  result.parts_left_out = parts.left_out;
  result.area_left_out = parts.area_left_out;
  return result;
}

}  // namespace

Partition partition(const Mesh& mesh, const PartitionOptions& options, Job& job) {
  check(mesh, options);
  Job::Part stage(job, "partitioning", 0.0, 1.0);
  const Parts parts = find_parts(mesh, options.proxies, options.leave_out, job);
  std::vector<double> history;
  std::vector<std::int32_t> seeds = first_seeds(mesh, parts, options, job);
  Job::Part rounds(job, "flooding", 0.1, 1.0);
  const Regions regions = lloyd(mesh.graph(), std::move(seeds), options.iterations, history, job);
  return make_partition(mesh, parts, regions, std::move(history), job);
}

}  // namespace isimp
