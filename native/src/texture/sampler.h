#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "isimp/mesh/mesh.h"
#include "isimp/texture/bake.h"

namespace isimp::detail {

using Rgba = std::array<float, 4>;  ///< 0 to 255

/// Looks up what the scan shows.
class Sampler {
 public:
  /// \throws InvalidInput  arrays that are not of this mesh
  Sampler(const Mesh& mesh, const Appearance& appearance);

  /// Bilinear in the picture of the face, or between the colours of its corners.
  [[nodiscard]] Rgba operator()(std::int32_t face, float b, float c) const;
  /// The mean over the surface: for what nothing is known of.
  [[nodiscard]] Rgba mean() const { return mean_; }
  /// Pixels of the picture per scene unit, squared, times the face's area; 0 for a face without a picture.
  [[nodiscard]] double pixels(std::int32_t face) const;

 private:
  [[nodiscard]] Rgba from_picture(std::int32_t face, float b, float c) const;

  const Appearance& look_;
  std::vector<std::uint8_t> repeats_;  // (F) whether the image repeats: the face's UVs leave it
  Rgba mean_{};
};

}  // namespace isimp::detail
