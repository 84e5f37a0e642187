#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "complex/state.h"
#include "judge/defects.h"
#include "planar/meet.h"
#include "planar/unit.h"

namespace isimp::meshing::planar {

/// Tests of the distance of moved corners from the scan, and of the scan from them.
class Near {
 public:
  Near(State& state, const Defects& defects, const std::vector<Unit>& units, const Around& around,
       const Places& places);

  /// Whether a place is near enough to a corner's start or its vertex, or to the scan in the charts at the corner.
  [[nodiscard]] bool is_on_scan(std::int32_t corner, const Vec3& x);
  /// Whether the polygons at a corner that slid are about as near to its vertex of the scan as before, as given planes
  /// are or as polygons were anywhere. If they left that vertex, they left a part of the scan. Uses the polygons as
  /// judged last.
  [[nodiscard]] bool is_covered(std::int32_t corner) const;

 private:
  [[nodiscard]] double gap(std::int32_t corner) const;
  [[nodiscard]] double from_held(std::int32_t corner) const;

  State& s_;  // not const, as its labels compute the faces of charts
  const Defects& f_;
  const std::vector<Unit>& units_;
  const Around& around_;
  const Places& places_;
  std::vector<double> before_;                               // by corner: the gap before anything moved
  double most_gap_ = 0;                                      // before anything moved
  std::map<std::int32_t, std::vector<std::int32_t>> faces_;  // faces of the scan by chart, cached
};

}  // namespace isimp::meshing::planar
