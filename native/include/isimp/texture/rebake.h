// An earlier bake, from which unchanged polygons take their texels.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/meshing/polygonize.h"
#include "isimp/partition/partition.h"
#include "isimp/texture/unwrap.h"

namespace isimp {

/// Counts of a polygon's texels by their source.
struct PolygonTexels {
  std::int64_t inside = 0;    ///< texels whose centres lie in the polygon
  std::int64_t searched = 0;  ///< inside texels at a place that no face was drawn to: they show the closest face
  std::int64_t unknown = 0;   ///< inside texels without a known colour: they show the mean colour

  PolygonTexels& operator+=(const PolygonTexels& other) {
    inside += other.inside;
    searched += other.searched;
    unknown += other.unknown;
    return *this;
  }
};

/// Input and result of an earlier bake of the same scan with the same options. Polygons that are baked from the same
/// faces to the same texels copy them from here: the result has the same bits as without it.
struct EarlierBake {
  const Partition& partition;
  const PolygonMesh& polygons;
  const Atlas& atlas;
  std::span<const std::uint8_t> color;                ///< as Texture::color
  std::span<const std::uint8_t> normal;               ///< as Texture::normal; empty: none was requested
  std::vector<std::span<const std::uint8_t>> layers;  ///< as Texture::layers
  std::span<const PolygonTexels> texels;              ///< (earlier Q)
};

/// Grey images of an earlier bake, and the polygons whose texels in them are still right.
struct EarlierGrey {
  std::span<const std::int32_t> same;  ///< (Q) the earlier polygon; kNone: the polygon is baked
  std::span<const std::uint8_t> grey;  ///< rows from the top
};

}  // namespace isimp
