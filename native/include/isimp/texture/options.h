#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <tuple>

#include "isimp/core/options.h"

namespace isimp {

/// How to make a texture of polygons. The table `fields` below describes each field.
struct TextureOptions {
  std::optional<std::int32_t> size{};
  std::optional<std::int32_t> tiles{};
  bool materials = false;
  double unfold = 40;
  std::optional<std::int32_t> gutter{};
  std::int32_t band = 2;
  bool normals = true;
  bool occlusion = false;
  std::optional<double> occlusion_distance{};
  std::int32_t occlusion_rays = 144;
  std::int32_t threads = 0;
};

constexpr auto fields(const TextureOptions*) {
  using O = TextureOptions;
  return std::tuple{
      field("size", &O::size, between(16, 16384), Unit::none,
            "Width and height of an image, in pixels. Not given: a power of two that keeps the scan's density, at "
            "most 8,192.")
          .shown("Size", "Width and height of the image in pixels; 0: as dense as the scan's images"),
      field("tiles", &O::tiles, between(1, 100), Unit::none,
            "How many images of that size the charts are laid out in, as UDIM tiles. Not given: one; without a size as "
            "many of 8,192 as keep the scan's density.")
          .shown("Tiles",
                 "How many images of that size, as UDIM tiles; 0: one, or if Size is 0 as many as the density needs"),
      field(
          "materials", &O::materials,
          "Keeps the scan's materials apart: each gets images of its own, and as many tiles. A polygon belongs to the "
          "material that most of its region shows.")
          .shown("Keep Materials Apart",
                 "Make a material with images of its own for each material of the scan. A polygon belongs to the one "
                 "that most of its region shows"),
      field("unfold", &O::unfold, between(0, 90), Unit::none,
            "Largest angle between neighbouring polygons that share a chart, in degrees. 0: a chart for each polygon."),
      field("gutter", &O::gutter, between(2, 64), Unit::none,
            "Least distance of two charts, in pixels. Not given: a 512th of the size, at least 3 and at most 16."),
      field("band", &O::band, between(0, 64), Unit::none,
            "Width of the band along the polygons' edges where the colours change over to those of the closest "
            "points, so that both sides of an edge agree; in pixels of an image of 2,048. 0: none."),
      field("normals", &O::normals, "Makes a tangent-space normal map too."),
      field("occlusion", &O::occlusion,
            "Makes an image of ambient occlusion too: how much light from all directions reaches the scan.")
          .shown("Ambient Occlusion",
                 "Make an image of how much light from all directions reaches the scan, for glTF and other tools"),
      field("occlusion_distance", &O::occlusion_distance, above(0), Unit::length,
            "How far away faces may lie that keep that light off. Not given: at any distance, which is dark inside a "
            "closed room.")
          .shown("Occlusion Distance",
                 "Faces beyond this distance cast no occlusion. 0: no limit, and closed rooms become dark",
                 {.high = 10}),
      field("occlusion_rays", &O::occlusion_rays, between(9, 9216), Unit::none,
            "Directions in which light is looked for, in multiples of 9. More: smoother, and slower."),
      threads_field(&O::threads),
  };
}

/// The fields of earlier versions.
constexpr auto gone_fields(const TextureOptions*) { return std::array{Gone{"height", false}}; }

}  // namespace isimp
