#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "images/relief.h"
#include "images/sampler.h"
#include "images/samples.h"

namespace isimp::detail {

/// The output for colours and normals of the texels, and the counts.
struct Canvas {
  Texture& texture;
  const Sampler& sampler;
  const std::vector<Eigen::Vector3f>& normals;
  std::vector<Sampler> layers;
  std::optional<Relief> relief;

  [[nodiscard]] std::size_t pixel(const Texel& texel) const {
    return static_cast<std::size_t>(texture.height - 1 - texel.y) * texture.side + texel.x;
  }
};

/// The appearance of a face at the points of a chart: each value changes by a constant from texel to texel.
struct FaceLook {
  enum class Steepness : std::uint8_t { unknown, flat, steep };  // steep: sampled by weights instead

  float x = 0, y = 0;                   ///< place of its first corner
  Eigen::Vector2f pixel, per_x, per_y;  ///< place in the picture, and how it grows
  Eigen::Vector3f normal, normal_per_x, normal_per_y;
  std::int32_t image = kNone;
  Steepness steepness = Steepness::unknown;
};

/// Computes the colours, normals and further layers of the texels of a polygon from the scan.
class ColourShade {
 public:
  ColourShade(const Scene& scene, const PolygonView& view, std::int32_t q, Canvas& canvas);
  ColourShade(const ColourShade&) = delete;
  ColourShade& operator=(const ColourShade&) = delete;
  ~ColourShade();

  void operator()(const Texel& texel, const Samples& samples);

 private:
  bool add_drawn(const Texel& texel, const Samples& samples);
  void add_searched(const Texel& texel, const Samples& samples, float share);
  void add(const Hit& hit, float weight);
  void add_layers(const Hit& hit, float weight);
  const FaceLook& look(std::int32_t index);
  void take_normal(std::uint8_t* rgb);

  const Mesh& mesh_;
  const PolygonView& view_;
  Canvas& canvas_;
  Eigen::Matrix3f tangent_;      // rows: right, up, out of the polygon
  std::vector<FaceLook> looks_;  // one for each of the view's faces
  Eigen::Array4f sum_;
  std::vector<Rgba> layer_sums_;
  Eigen::Vector3f normal_ = Eigen::Vector3f::Zero();
  float weight_ = 0;
  std::int32_t last_ = kNone, last_x_ = kNone,
               last_y_ = kNone;  // the face that a search found last, and for which texel
  std::int32_t polygon_;
  PolygonTexels counts_;
  bool with_normals_, with_layers_;
};

}  // namespace isimp::detail
