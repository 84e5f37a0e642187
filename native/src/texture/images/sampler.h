#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "isimp/mesh/mesh.h"
#include "isimp/texture/bake.h"

namespace isimp::detail {

using Rgba = Eigen::Array4f;  ///< 0 to 255

/// Samples the images of the scan.
class Sampler {
 public:
  /// \throws InvalidInput  arrays that are not of this mesh
  Sampler(const Mesh& mesh, const Appearance& appearance);

  /// Bilinear in the picture of the face, or between the colours of its corners.
  [[nodiscard]] Rgba operator()(std::int32_t face, float b, float c) const;
  /// Bilinear in a picture, at x pixels from its left and y from its upper edge, minus a half.
  [[nodiscard]] Rgba at_pixel(std::int32_t image, float x, float y) const;
  /// The pixels at the corners of a face, for `at_pixel`. Empty if it shows no picture, or repeats it.
  [[nodiscard]] std::optional<std::array<Eigen::Vector2f, 3>> corner_pixels(std::int32_t face) const;
  [[nodiscard]] std::int32_t image(std::int32_t face) const { return look_.image[face]; }
  /// The mean over the surface: for places without a known colour.
  [[nodiscard]] Rgba mean() const { return mean_; }
  /// Pixels of the picture per scene unit, squared, times the face's area; 0 for a face without a picture.
  [[nodiscard]] double pixels(std::int32_t face) const;

 private:
  [[nodiscard]] Rgba from_picture(std::int32_t face, float b, float c) const;
  static Rgba in(const Picture& picture, float x, float y, bool repeat);

  const Appearance& look_;
  std::vector<std::uint8_t> repeats_;  // (F) whether the image repeats: the face's UVs leave it
  Rgba mean_ = Rgba::Zero();
};

}  // namespace isimp::detail
