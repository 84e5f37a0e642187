#include "isimp/simplify/constraints.h"

#include <algorithm>
#include <string>
#include <utility>

#include "components.h"
#include "isimp/core/errors.h"

namespace isimp {
namespace {

/// Clears the faces of components that partitions leave out.
void close_left_out(const Mesh& mesh, std::int32_t proxies, double leave_out, std::vector<std::uint8_t>& is_open,
                    Job& job) {
  const Components components = find_components(mesh, proxies, leave_out, job);
  for (std::size_t f = 0; f < is_open.size(); ++f)
    if (!components.all[mesh.component()[f]].kept) is_open[f] = 0;
}

void check_faces(const Mesh& mesh, std::span<const std::int32_t> faces) {
  for (const std::int32_t f : faces)
    if (f < 0 || f >= mesh.face_count())
      throw InvalidInput("faces must be in [0, " + std::to_string(mesh.face_count()) + "), got " + std::to_string(f));
}

std::vector<std::uint8_t> chosen_faces(const Mesh& mesh, std::span<const std::int32_t> faces) {
  check_faces(mesh, faces);
  std::vector<std::uint8_t> chosen(static_cast<std::size_t>(mesh.face_count()), 0);
  for (const std::int32_t f : faces) chosen[f] = 1;
  return chosen;
}

bool has_locked(const Partition* before) {
  return before != nullptr && std::ranges::any_of(before->region_locked, [](std::uint8_t locked) { return locked; });
}

}  // namespace

Guides Constraints::with_cuts() const {
  Guides all = guides;
  all.barriers.insert(all.barriers.end(), cuts.begin(), cuts.end());
  return all;
}

std::optional<std::vector<std::int32_t>> open_faces(const Mesh& mesh, const Constraints& constraints,
                                                    std::int32_t proxies, double leave_out, Job& job) {
  const Partition* before = constraints.before;
  const auto count = static_cast<std::size_t>(mesh.face_count());
  if (before != nullptr) check_is_of(mesh, *before);
  const bool locked = has_locked(before);
  if (!constraints.faces && !locked) return std::nullopt;
  std::vector<std::uint8_t> is_open(count, 1);
  if (constraints.faces)
    is_open = chosen_faces(mesh, *constraints.faces);
  else
    close_left_out(mesh, proxies, leave_out, is_open, job);
  std::vector<std::int32_t> open;
  for (std::size_t f = 0; f < count; ++f) {
    const std::int32_t region = locked ? before->face_region[f] : kNone;
    const bool stays = region != kNone && before->region_locked[region] != 0;
    if (is_open[f] != 0 && !stays) open.push_back(static_cast<std::int32_t>(f));
  }
  if (open.empty()) throw InvalidInput(locked ? "all faces that would be split are locked" : "no face is given");
  return open;
}

}  // namespace isimp
