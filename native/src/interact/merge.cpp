#include "isimp/interact/merge.h"

#include <algorithm>
#include <string>

#include "edit.h"
#include "isimp/core/errors.h"

namespace isimp {
namespace {

std::string named(std::int32_t face, std::int32_t other) {
  return "faces " + std::to_string(face) + " and " + std::to_string(other);
}

}  // namespace

Partition merge_regions(const Mesh& mesh, const Partition& partition, std::int32_t face, std::int32_t other, Job& job) {
  Edit edit(mesh, partition);
  const std::int32_t into = edit.region_at(face), gone = edit.region_at(other);
  if (into == gone) throw InvalidInput(named(face, other) + " are in one region: there is nothing to merge");
  job.poll();
  edit.hints = edit.take_region(edit.at(other));
  bool beside = false;
  for (const std::int32_t i : edit.hints)
    for (const std::int32_t j : edit.graph.neighbours[i]) beside |= edit.labels.get(j) == into;
  if (!beside)
    throw InvalidInput("the regions of " + named(face, other) + " share no edge: only neighbours can be merged");
  for (const std::int32_t i : edit.hints) edit.labels.set(i, into);
  edit.result.region_sum[into].add(edit.result.region_sum[gone]);
  edit.result.region_seed[into] = kNone;
  edit.remove_region(gone);
  return edit.finish();
}

}  // namespace isimp
