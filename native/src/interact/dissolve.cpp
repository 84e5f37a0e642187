#include "dissolve.h"

#include <utility>
#include <vector>

namespace isimp {

bool dissolve(Edit& edit, std::int32_t region, std::int32_t face, Job& job) {
  std::vector<std::int32_t> faces = edit.take_region(face);
  std::vector<std::int32_t> touched;
  if (!flood_from_around(edit.graph, edit.labels, faces, edit.result.region_sum, touched)) return false;
  job.report(0.5);
  edit.result.region_sum[region] = {};
  edit.borders = edit.relax(faces, kNone, job);
  edit.remove_region(region);
  edit.hints = std::move(faces);
  return true;
}

}  // namespace isimp
