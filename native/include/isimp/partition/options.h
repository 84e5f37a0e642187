#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>

#include "isimp/core/options.h"
#include "isimp/parallel/flooder.h"

namespace isimp {

/// Where the first proxies are put.
enum class Seeding {
  random,        ///< distinct faces drawn by `seed`
  farthest,      ///< each the face whose normal and place are farthest from all before
  hierarchical,  ///< the faces nearest to the regions that Method::hierarchy gives
};

/// How the regions are found.
enum class Method {
  lloyd,      ///< the 2004 paper's and the thesis's own: flooding and fitting in turn, from seeds
  hierarchy,  ///< merging of a hierarchy of patches, then relaxation of the borders: the best and the fastest
  teleport,   ///< lloyd, then merge the cheapest pair and split the worst region until it no longer helps
  naive,      ///< as lloyd, each face looking at the nearest regions at once: the thesis's data-parallel flooding
  queued,     ///< as lloyd, from a queue all of whose faces are flooded at once: the thesis's queued flooding
  hybrid,     ///< on a decimated mesh, and carried back: the thesis's hybrid
};

/// How the pieces that parallel flooding leaves become connected regions, and which of its two ways Method::hybrid
/// goes.
enum class Connect {
  repair,  ///< the largest piece of each region grows over the others: parallel, and it loses less
  flood,   ///< one sequential round of lloyd, the thesis's own
};

/// How to split a surface into regions. What each field means stands in `fields` below.
///
/// At most one of `proxies`, `detail`, `tolerance` and `bound` is given; none: `detail` at kDefaultDetail.
struct PartitionOptions {
  std::optional<std::int32_t> proxies = std::nullopt;
  std::optional<double> detail = std::nullopt;
  std::optional<double> tolerance = std::nullopt;
  std::optional<double> bound = std::nullopt;
  std::optional<double> noise = std::nullopt;
  bool snap = true;
  double adaptivity = 0.0;
  double leave_out = 0.001;
  std::uint64_t seed = 1;
  std::int32_t iterations = 20;
  Seeding seeding = Seeding::random;
  Method method = Method::hierarchy;
  std::int32_t threads = 0;
  std::string backend = "cpu";
  std::int32_t nearest = 8;
  parallel::Search search = parallel::Search::grid;
  Connect connect = Connect::repair;
  double fraction = 0.125;
};

/// What PartitionOptions::detail is if neither it nor another way to choose the number is given.
inline constexpr double kDefaultDetail = 0.005;

constexpr auto fields(const PartitionOptions*) {
  using O = PartitionOptions;
  return std::tuple{
      field("proxies", &O::proxies, at_least(1), Unit::none,
            "So many regions, from 1 to the number of faces; at most one of this, detail, tolerance and bound."),
      field("detail", &O::detail, above_to(0, 1), Unit::none,
            "As many regions as the surface shows at a tolerance of this share of its size; 0.02, 0.01, 0.005, 0.0025 "
            "and 0.00125 are from very coarse to very fine. 0.005 if nothing says how many."),
      field("tolerance", &O::tolerance, above(0), Unit::length,
            "The same with the tolerance in scene units: about the mean distance of the surface from the planes of its "
            "regions."),
      field("bound", &O::bound, above(0), Unit::length,
            "As few regions as there may be with each vertex this near to its region's plane, scene units; by method "
            "'hierarchy'."),
      field("noise", &O::noise, at_least(0), Unit::length,
            "Standard deviation of the scan's noise, scene units, below 3.5 of which no tolerance counts; None: "
            "estimated. 0 for what was drawn and not scanned."),
      field("snap", &O::snap,
            "Where the surface clearly is made of so many planes, take that number; with detail and tolerance."),
      field("adaptivity", &O::adaptivity, between(0, 1), Unit::none,
            "How much denser regions get where the surface is rough; 0.25 is good for figures, 0 for buildings and "
            "drawn models."),
      field("leave_out", &O::leave_out, from_below(0, 1), Unit::none,
            "Components each below this share of the whole area are left out, smallest first, while all of them "
            "together stay below ten times it; 0 keeps everything."),
      field("seed", &O::seed, at_least(0), Unit::none, "The number that starts the random seeding."),
      field("iterations", &O::iterations, at_least(1), Unit::none, "Upper bound on flood-and-fit rounds."),
      choice(
          "seeding", &O::seeding,
          std::array<Choice<O, Seeding, 3>::Value, 3>{
              {{"random", Seeding::random}, {"farthest", Seeding::farthest}, {"hierarchical", Seeding::hierarchical}}},
          "Where 'lloyd' and 'teleport' put the first proxies: 'random', distinct faces drawn by `seed`; "
          "'farthest', each the face whose normal and place are farthest from all before; 'hierarchical', the faces "
          "nearest to the regions that 'hierarchy' gives."),
      choice("method", &O::method,
             std::array<Choice<O, Method, 6>::Value, 6>{{{"lloyd", Method::lloyd},
                                                         {"hierarchy", Method::hierarchy},
                                                         {"teleport", Method::teleport},
                                                         {"naive", Method::naive},
                                                         {"queued", Method::queued},
                                                         {"hybrid", Method::hybrid}}},
             "How the regions are found: 'hierarchy', merging of a hierarchy of patches, then relaxation of the "
             "borders, the best and the fastest; 'lloyd', flooding and fitting in turn, the 2004 paper's and the "
             "thesis's own; 'teleport', that, then merging the cheapest pair and splitting the worst region until it "
             "no longer helps; 'naive' and 'queued', as 'lloyd' but all faces, or all of a queue, flooded at once, for "
             "many processors: the thesis's data-parallel floodings; 'hybrid', 'lloyd' on a decimated mesh, carried "
             "back."),
      field("threads", &O::threads, at_least(0), Unit::none,
            "How many threads may work, at most 256 or as many as there are cores; 0: as many as there are cores. The "
            "result does not depend on it."),
      field("backend", &O::backend,
            "Where 'naive' and 'queued' run: one of backends(), 'cpu' among them. Same labels on all."),
      field("nearest", &O::nearest, between(1, parallel::Flooder::kMostNearest), Unit::none,
            "How many of the nearest regions a face looks at in 'naive'."),
      choice("search", &O::search,
             std::array<Choice<O, parallel::Search, 2>::Value, 2>{
                 {{"grid", parallel::Search::grid}, {"brute", parallel::Search::brute}}},
             "How 'naive' finds them: by a 'grid', or by looking at all regions, 'brute', as the thesis has it."),
      choice("connect", &O::connect,
             std::array<Choice<O, Connect, 2>::Value, 2>{{{"repair", Connect::repair}, {"flood", Connect::flood}}},
             "How the regions of 'naive' and 'queued' become connected at the end: 'repair', the largest piece of each "
             "grows over the others; 'flood', one sequential round, as the thesis has it, which loses more. Of "
             "'hybrid' 'flood' is the thesis's, and 'repair' takes the default method and relaxed borders."),
      field("fraction", &O::fraction, above_to(0, 1), Unit::none,
            "Of the faces what 'hybrid' keeps when it decimates."),
  };
}

}  // namespace isimp
