#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/parallel/sums.h"

namespace isimp::parallel {

/// limit: the most regions that naive flooding compares for a face.
inline constexpr std::int32_t kMostNearest = 32;

/// A surface in the form for flooding. Index N is a sentinel that stands for "no neighbour".
struct FloodSurface {
  std::span<const float> faces;              ///< (4 N) unit normal's x, y, z, and the area, in any unit
  std::span<const std::int32_t> neighbours;  ///< (3 N) in [0, N]
};

/// The input of flooding: a seed and a proxy for each region.
struct Proxies {
  std::vector<std::int32_t> seed;  ///< (R) distinct faces; each stays with its region, so that none is empty
  std::vector<float> normal;       ///< (3 R) unit, or zero
  std::vector<float> centre;       ///< (3 R) centres of the regions, in the unit of `place`; only for naive flooding
  friend bool operator==(const Proxies&, const Proxies&) = default;
};

/// One surface in the memory of one back end, and its labels during a partition. One call at a time.
///
/// The error of a face under a proxy is |n - n'|^2, and at least 2^-24: smaller errors are rounding and count as equal.
/// Faces are processed in steps, all faces of a step at once from the result of the step before, so that no result
/// depends on the order of threads. Ties prefer the label that a face has, then the region of the lower number. Every
/// step uses integers, comparisons and single IEEE operations on floats only, which all back ends round alike.
class Flooder {
 public:
  virtual ~Flooder() = default;

  /// Sets the places of the faces, which naive flooding needs.
  /// \param centre  (3 N) in [0, 1], all axes in the same unit
  /// \param component  (N) from 0; a face takes regions that are seeded in its own component only
  virtual void place(std::span<const float> centre, std::span<const std::int32_t> component) = 0;
  [[nodiscard]] virtual bool placed() const = 0;

  /// Floods from the seeds by a queue: in each step every face of the queue takes the best of the regions next to it,
  /// and the neighbours of the faces that changed make the next queue. A region may end in several pieces. Faces that no
  /// seed reaches get -1.
  /// Cost: O(faces queued); some sqrt(N / R) steps and as many again until the borders rest.
  /// Source: the thesis's queued flooding.
  /// \return the steps
  virtual std::int32_t queued(const Proxies& proxies, std::int32_t threads, Job& job) = 0;
  /// Labels every face by the best of the `nearest` regions whose centres are nearest to its own, connected or not.
  /// \param nearest  in [1, kMostNearest]
  /// \param brute  compares all regions in place of the regions in a grid; the same result
  /// Cost: about O(N nearest); by brute force O(N R).
  /// Source: the thesis's naive one
  virtual void naive(const Proxies& proxies, std::int32_t nearest, bool brute, std::int32_t threads, Job& job) = 0;

  /// The sums of the regions' faces; also of the centres if the faces are placed.
  struct Fit {
    std::vector<RegionSum> sum;                 ///< (R)
    std::vector<std::array<double, 3>> centre;  ///< (R) area times centre; empty where faces are not placed
  };
  [[nodiscard]] virtual Fit fit(std::int32_t threads) = 0;
  /// The face of each region that is nearest to the region's normal; ties to the lower face. Every region has a face.
  [[nodiscard]] virtual std::vector<std::int32_t> nearest_faces(const Proxies& proxies, std::int32_t threads) = 0;

  /// Saves the labels; only the next call after this one may restore them.
  virtual void keep() = 0;
  virtual void go_back() = 0;

  /// Leaves each region the largest of its pieces, by area; frees the faces of all other pieces.
  /// \return number of freed faces
  virtual std::int32_t cut_to_pieces(std::int32_t threads, Job& job) = 0;
  /// Adds the free faces to the regions around them for good, least errors first in levels of a quarter octave, so that
  /// regions stay connected.
  /// \return the steps
  virtual std::int32_t fill(const Proxies& proxies, std::int32_t threads, Job& job) = 0;

  /// \param labels (N) receives the region of each face, -1 for none
  virtual void labels(std::span<std::int32_t> labels) const = 0;

  /// Memory of the device that is held for this surface, all of it for the life of the flooder. Arrays that a CPU reads
  /// in place do not count.
  struct MemoryUse {
    std::size_t bytes = 0;
    std::int64_t allocations = 0;  ///< number of allocations on the device
  };
  [[nodiscard]] virtual MemoryUse memory() const = 0;
};

}  // namespace isimp::parallel
