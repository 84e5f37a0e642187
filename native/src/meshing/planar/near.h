#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "complex/state.h"
#include "judge/findings.h"
#include "planar/meet.h"
#include "planar/unit.h"

namespace isimp::meshing::planar {

/// How far corners that move are from the scan, and the scan from them.
class Near {
 public:
  Near(State& state, const Findings& findings, const std::vector<Unit>& units, const Around& around,
       const Places& places);

  /// Whether a place is no further from a corner's start than the reach that is asked for, or from the corner's vertex or
  /// the scan round it than it may.
  [[nodiscard]] bool is_on_scan(std::int32_t corner, const Vec3& x);
  /// Whether the polygons round a corner that slid are about as near to its vertex of the scan as they were or as given planes
  /// are, or as polygons were anywhere: where they left that vertex, they left a part of the scan. Asks of the polygons as judged last.
  [[nodiscard]] bool is_covered(std::int32_t corner) const;

 private:
  [[nodiscard]] double gap(std::int32_t corner) const;
  [[nodiscard]] double from_held(std::int32_t corner) const;

  State& s_;  // its labels are asked for faces
  const Findings& f_;
  const std::vector<Unit>& units_;
  const Around& around_;
  const Places& places_;
  std::vector<double> before_;                               // by corner: the gap before anything moved
  double most_gap_ = 0;                                      // before anything moved
  std::map<std::int32_t, std::vector<std::int32_t>> faces_;  // of the scan, by piece: those that were asked for
};

}  // namespace isimp::meshing::planar
