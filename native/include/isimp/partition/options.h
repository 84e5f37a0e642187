// The options of partition.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>

#include "isimp/core/options.h"

namespace isimp {

/// The places of the first proxies.
enum class Seeding {
  random,        ///< distinct faces drawn by `seed`
  farthest,      ///< each the face whose normal and place are farthest from all before
  hierarchical,  ///< the faces nearest to the regions that Method::hierarchy gives
};

/// How regions are found.
enum class Method {
  lloyd,      ///< the 2004 paper's and the thesis's own: flooding and fitting in turn, from seeds
  hierarchy,  ///< merging of a hierarchy of patches, then relaxation of the borders: the best and the fastest
  teleport,   ///< lloyd, then merge the cheapest pair and split the worst region until it no longer helps
  naive,      ///< as lloyd, each face compares the nearest regions at once: the thesis's data-parallel flooding
  queued,     ///< as lloyd, from a queue all of whose faces are flooded at once: the thesis's queued flooding
  hybrid,     ///< on a decimated mesh, then transferred to the faces: the thesis's hybrid
};

/// How the pieces that parallel flooding leaves become connected regions, and which of its two ways Method::hybrid
/// uses.
enum class Connect {
  repair,  ///< the largest piece of each region grows over the others: parallel, and it loses less
  flood,   ///< one sequential round of lloyd, the thesis's own
};

/// How Method::naive finds the regions nearest to a face.
enum class Search {
  grid,   ///< by a grid of the regions' centres
  brute,  ///< by a search of all of them, as in the thesis: O(F P); the same regions
};

/// The measure of the difference between a face and its region.
enum class Metric {
  normals,   ///< the square difference of the normals, L2,1: the 2004 paper's
  mixed,     ///< that, and the square distance from the region's plane of least squares
  distance,  ///< that distance alone, L2
};

inline constexpr NamedValue<Metric> kMetrics[] = {
    {"mixed", Metric::mixed, {"Mixed", "Direction and distance: polygons are nearest to the scan"}},
    {"normals", Metric::normals, {"Normals", "Direction of the face, as in the first paper"}},
    {"distance", Metric::distance, {"Distance", "Distance of the face from the plane of the region"}}};

/// How to split a surface into regions. The table `fields` below describes each field.
///
/// At most one of `proxies`, `triangles`, `detail`, `tolerance` and `bound` is given; none: `detail` at kDefaultDetail.
struct PartitionOptions {
  std::optional<std::int32_t> proxies = std::nullopt;
  std::optional<std::int32_t> triangles = std::nullopt;
  std::optional<double> detail = std::nullopt;
  std::optional<double> tolerance = std::nullopt;
  std::optional<double> bound = std::nullopt;
  std::optional<double> noise = std::nullopt;
  bool snap = true;
  std::optional<double> sharp_edges = std::nullopt;
  double adaptivity = 0.0;
  double smooth = 0.5;
  Metric metric = Metric::mixed;
  bool curved = false;
  double leave_out = 0.001;
  std::uint64_t seed = 1;
  std::int32_t iterations = 20;
  Seeding seeding = Seeding::random;
  Method method = Method::hierarchy;
  std::int32_t threads = 0;
  std::string backend = "cpu";
  std::int32_t nearest = 8;
  Search search = Search::grid;
  Connect connect = Connect::repair;
  double fraction = 0.125;
};

// tuned found
/// The value of PartitionOptions::detail if neither it nor another way to choose the number is given.
inline constexpr double kDefaultDetail = 0.005;
/// The finest step of the detail slider, as a share of the surface's size.
inline constexpr double kFinestDetail = 0.00125;  // limit

constexpr auto fields(const PartitionOptions*) {
  using O = PartitionOptions;
  return std::tuple{
      field("proxies", &O::proxies, at_least(1), Unit::none,
            "Number of regions, at most the number of faces. Give at most one of proxies, triangles, detail, tolerance "
            "and bound.")
          .shown("Regions", "Number of regions. Each becomes one polygon, or a few", {.high = 5000}),
      field("triangles", &O::triangles, at_least(2), Unit::none,
            "As many regions as the polygons can have that make at most this many triangles. `partition` alone takes "
            "one region for each 3.5; `polygonize_within` and all that uses it try several numbers.")
          .shown("Triangles", "The polygons of Mesh make at most this many triangles, as a game counts them",
                 {.high = 100000}),
      field("detail", &O::detail, above_to(0, 1), Unit::none,
            "Chooses the number of regions: smallest visible detail, as a share of the surface's size. 0.02, 0.01, "
            "0.005, 0.0025 and 0.00125 go from very coarse to very fine. 0.005 if none of the five is given.")
          .shown("Detail", "Shapes below this share of the scan's size are ignored. A smaller value gives more regions",
                 {.low = 0.0001, .high = 0.05, .digits = 4}),
      field("tolerance", &O::tolerance, above(0), Unit::length,
            "As detail, but in scene units: about the mean distance of the surface from the planes of its regions.")
          .shown("Tolerance", "Shapes below this length are ignored. A smaller value gives more regions", {.high = 10}),
      field("bound", &O::bound, above(0), Unit::length,
            "As few regions as possible with every vertex within this distance of its region's plane, in scene "
            "units. Method 'hierarchy' only.")
          .shown("Bound", "Largest distance of a vertex from its region's plane. A smaller value gives more regions",
                 {.high = 10}),
      field("noise", &O::noise, at_least(0), Unit::length,
            "Standard deviation of the scan's noise, in scene units. Detail below 2.4 times it is ignored. None: "
            "estimated. 0: a drawn model, not a scan.")
          .shown("Noise", "Standard deviation of the scan's points, in the scan's units. Below 0: estimated",
                 {.high = 0.1}),
      field("snap", &O::snap,
            "If the surface clearly consists of a certain number of planes, use that number. For detail and "
            "tolerance.")
          .shown("Snap to Planes", "If the shape clearly consists of planes, make one region for each plane"),
      field("sharp_edges", &O::sharp_edges, at_least(0), Unit::length,
            "Rounded and dented edges become sharp: regions at edges that are narrower than this go to the planes "
            "beside them, in scene units. 0: three mean edges of the scan. None: the same where a detail finds a scan "
            "of planes with noise and `snap` is on; else such regions stay. An asked number of regions is left. Not "
            "for a "
            "bound or a part of a partition.")
          .shown("Edge Width",
                 "Regions at edges that are narrower than this go to the planes beside them, in the scan's units. 0: "
                 "three mean edges. Below 0: only where the scan is of planes",
                 {.high = 0.1}),
      field("adaptivity", &O::adaptivity, between(0, 1), Unit::none,
            "Smaller regions where the surface is rough. 0.25 suits figures, 0 suits buildings and drawn models.")
          .shown("Finer Where Rough", "Smaller regions where the scan is rough. 0: the same detail everywhere"),
      field("smooth", &O::smooth, between(0, 1), Unit::none,
            "Weight of short, straight borders relative to the error. 0: least error. 1: cleanest shapes. For method "
            "'hierarchy', and for detail and tolerance.")
          .shown("Straight Borders",
                 "How much short, straight borders count beside the error. 0: least error. 1: cleanest shapes"),
      choice("metric", &O::metric, kMetrics,
             "The measure of the difference between a face and a region. It decides to which of two regions a face at "
             "their border belongs. 'mixed': the difference of the normals and the distance from the plane of the "
             "region; polygons are nearest to the scan. 'normals': the difference of the normals alone, the error of "
             "the 2004 paper. 'distance': the distance alone. For method 'hierarchy', and for detail and tolerance.")
          .shown("Difference", "The measure that decides to which of two regions a face at their border belongs"),
      field("curved", &O::curved,
            "Makes round parts round: cylinders, cones, spheres, surfaces of revolution and extrusions become "
            "regular segments; the number of regions is then about the given one. Not for a bound.")
          .shown("Round Parts",
                 "Cylinders, cones, spheres, surfaces of revolution and extrusions become regular segments"),
      field("leave_out", &O::leave_out, from_below(0, 1), Unit::none,
            "Components below this share of the total area get no region, smallest first, as long as all of them "
            "together stay below ten times it; below twenty times it, where each has less than a tenth of the mean "
            "area of the requested `proxies`. 0 keeps every component.")
          .shown("Ignore Parts Below",
                 "Loose parts below this share of the total area get no region and no polygon. 0: keep every part",
                 {.high = 0.99, .digits = 4}),
      field("seed", &O::seed, at_least(0), Unit::none, "Seed of the random numbers.")
          .shown("Seed", "Seed of the random numbers"),
      field("iterations", &O::iterations, at_least(1), Unit::none, "Maximum number of rounds of flooding and fitting.")
          .shown("Iterations", "Maximum number of rounds of flooding and fitting. Fewer if the regions stop changing",
                 {.high = 100}),
      choice("seeding", &O::seeding,
             {{"random", Seeding::random, {"Random", "Random faces"}},
              {"farthest",
               Seeding::farthest,
               {"Farthest", "Each face where the surface differs most from all regions so far"}},
              {"hierarchical",
               Seeding::hierarchical,
               {"Hierarchical", "One face in each region of the method Hierarchy"}}},
             "First seeds of 'lloyd' and 'teleport'. 'random': distinct random faces. 'farthest': each the face that "
             "differs most from all seeds before. 'hierarchical': one face in each region of 'hierarchy'.")
          .shown("Start", "Faces at which the first regions start (all methods except Hierarchy)"),
      choice(
          "method", &O::method,
          {{"hierarchy",
            Method::hierarchy,
            {"Hierarchy", "Merge small patches, then relax the borders: the fastest, with the least error"}},
           {"teleport",
            Method::teleport,
            {"Teleport", "As Lloyd; then merge the cheapest pair and split the worst region while the error falls"}},
           {"lloyd",
            Method::lloyd,
            {"Lloyd", "Flood from the seeds and fit planes, alternately: the method of the first paper"}},
           {"queued", Method::queued, {"Queued", "As Lloyd, but flood all faces of a queue at once: for GPUs"}},
           {"naive", Method::naive, {"Naive", "As Lloyd, but every face chooses among the nearest regions: for GPUs"}},
           {"hybrid",
            Method::hybrid,
            {"Hybrid", "Partition a decimated copy, and carry the regions back to the scan"}}},
          "How the regions are found. 'hierarchy': merge small patches, then relax the borders; the best and the"
          " fastest. 'lloyd': flood and fit in turn, the method of the 2004 paper. 'teleport': as 'lloyd', then "
          "merge the cheapest pair and split the worst region while the error falls. 'naive' and 'queued': as "
          "'lloyd', with all faces, or all of a queue, flooded at once; for GPUs. 'hybrid': partition a "
          "decimated mesh, and carry the regions back.")
          .shown("Method", "Algorithm of the partition"),
      threads_field(&O::threads),
      field("backend", &O::backend,
            "Where 'naive' and 'queued' run: one of backends(). The labels are the same on all."),
      field("nearest", &O::nearest, between(1, 32), Unit::none,
            "Number of nearest regions that a face compares in 'naive'."),
      choice("search", &O::search, {{"grid", Search::grid}, {"brute", Search::brute}},
             "How 'naive' finds them: 'grid', or 'brute', which compares all regions, as in the thesis."),
      choice("connect", &O::connect, {{"repair", Connect::repair}, {"flood", Connect::flood}},
             "How 'naive' and 'queued' make regions connected at the end. 'repair': the largest piece of each "
             "region grows over the others. 'flood': one sequential round, as in the thesis, with a larger error. "
             "In 'hybrid', 'flood' follows the thesis, and 'repair' uses method 'hierarchy' and relaxes the "
             "borders."),
      field("fraction", &O::fraction, above_to(0, 1), Unit::none,
            "Share of the faces that 'hybrid' keeps when it decimates."),
  };
}

/// The fields of earlier versions.
constexpr auto gone_fields(const PartitionOptions*) { return std::array{Gone{"symmetry", "none"}}; }

}  // namespace isimp
