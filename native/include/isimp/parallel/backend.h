#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "isimp/parallel/flooder.h"
#include "isimp/parallel/sums.h"

namespace isimp::parallel {

inline constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();  // mark

/// The data-parallel kernels of one back end. Their arguments are spans of plain numbers, no mesh; the memory of the
/// device is hidden. Every kernel gives the same bits on every back end and any number of threads.
class Kernels {
 public:
  virtual ~Kernels() = default;

  /// Sums area and area times normal over the faces of each region.
  ///
  /// The sums are made of integers, steps of at most N * max(area) * 2^-60, so that no order of adding can change a
  /// bit: a sum over k faces is within k half steps of the exact one.
  ///
  /// \param faces    (4 N) of each face in turn: the unit normal's x, y, z, and the area, in any unit, 0 allowed
  /// \param labels   (N) the region of each face, in [0, regions); -1 for a face to skip
  /// \param regions  R, at least 0
  /// \param threads  the most threads to use, where the back end has threads; 0: as many as there are cores
  /// \return (R) zero for a region without faces
  /// \throws InvalidInput  lengths that do not agree; a label out of range; a face whose numbers are not finite, whose
  ///                       normal is longer than 1 or whose area is negative: the message names the first
  /// \throws Error         the device has too little memory or failed
  /// Cost: O(N + R) time; memory on the device 20 N + 32 R bytes, on the CPU 32 R.
  /// Source: Cohen-Steiner, Alliez, Desbrun 2004, section 3.3 (proxy fitting).
  [[nodiscard]] virtual std::vector<RegionSum> fit(std::span<const float> faces, std::span<const std::int32_t> labels,
                                                   std::int32_t regions, std::int32_t threads) const = 0;

  /// Loads a surface for flooding. Its arrays must outlive the flooder, which reads them in place on the CPU.
  /// Memory: up to 40 bytes a face on the CPU, without the surface; on a device 68; 16 more each while naive flooding
  /// has its places and while regions are cut to pieces.
  /// \param most  bytes of the device that the flooder may ever hold
  /// \throws InvalidInput  lengths that do not agree; a face that fit() refuses; a neighbour outside [0, N]
  /// \throws Error         the device has too little memory, or more than `most` is needed, or it failed. Any call to
  ///                       the flooder may throw this too, and the flooder can be used again afterwards
  [[nodiscard]] virtual std::unique_ptr<Flooder> load(const FloodSurface& surface,
                                                      std::size_t most = kNoLimit) const = 0;
};

/// The message of a back end that ran out of memory; it adds that the CPU can do the same.
/// \param doing  "flooding".
/// \param wanted, held  bytes of the last request, and bytes that it had already
[[nodiscard]] std::string out_of_memory(std::string_view backend, std::string_view doing, std::size_t faces,
                                        std::size_t wanted, std::size_t held);
/// The message of any other failure.
/// \param reason  the back end's own message
[[nodiscard]] std::string out_of_order(std::string_view backend, std::string_view doing, std::size_t faces,
                                       std::string_view reason);

/// The back ends that work here: "cpu" always; "cuda" where a device is present, the driver works and this build has
/// the CUDA part. The first call searches for devices, which can take a second if there are any.
[[nodiscard]] std::vector<std::string> backends();

/// The kernels of a back end, which live as long as the program.
/// \throws InvalidInput  there is no such back end, or it does not work here; the message gives the reason and the
///                       choices
[[nodiscard]] const Kernels& backend(std::string_view name);

}  // namespace isimp::parallel
