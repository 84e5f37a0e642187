#pragma once

#include <cstdint>
#include <tuple>

#include "isimp/core/options.h"

namespace isimp {

/// How to make polygons of regions. What each field means stands in `fields` below.
struct MeshingOptions {
  double chord_tolerance = 0.7;
  double chord_area = 0.53;
  double reach = 0.01;
  std::int32_t flatten = 30;
  std::int32_t flatness_from = 100;
  double flatness = 0.005;
  double repair_budget = 4;
  std::int32_t threads = 0;
};

constexpr auto fields(const MeshingOptions*) {
  using O = MeshingOptions;
  return std::tuple{
      field(
          "chord_tolerance", &O::chord_tolerance, between(0, 100), Unit::none,
          "A boundary is subdivided where it leaves its chord by more than this times sqrt(area / regions). It counts "
          "the less, the flatter the two regions meet."),
      field("chord_area", &O::chord_area, between(0, 100), Unit::none,
            "The chords of a region may leave out or add at most this share of its area, so that small regions keep "
            "their shape. It counts the less, the flatter the two regions meet."),
      field("reach", &O::reach, between(0, 1), Unit::none,
            "No corner is moved further than this share of the diagonal from the scan's vertex it stands for."),
      field("flatten", &O::flatten, between(0, 10000), Unit::none,
            "Rounds of planes and corners in turn; 0 leaves the first placement."),
      field("flatness_from", &O::flatness_from, any(), Unit::none,
            "With fewer regions than this there is no bound on flatness: they are bent themselves."),
      field("flatness", &O::flatness, between(0, 100), Unit::none,
            "Polygons bent by more than this share of the diagonal are split; no bound at 0."),
      field("repair_budget", &O::repair_budget, between(0, 1000), Unit::none,
            "Splits and diagonals that the repair may make, as a share of the polygons before; those that turn out not "
            "to be needed are taken back."),
      field("threads", &O::threads, at_least(0), Unit::none,
            "How many threads may work, at most 256 or as many as there are cores; 0: as many as there are cores. The "
            "result does not depend on it."),
  };
}

}  // namespace isimp
