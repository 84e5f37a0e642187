#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "isimp/core/array.h"
#include "isimp/core/job.h"
#include "isimp/core/types.h"
#include "isimp/mesh/mesh.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/partition/partition.h"
#include "isimp/texture/options.h"
#include "isimp/texture/unwrap.h"

namespace isimp {

/// An image of the scan: rows of RGBA from the top, one of the two spans.
struct Picture {
  std::int32_t width = 0, height = 0;
  std::span<const std::uint8_t> bytes;   ///< (4 * width * height) 8 bits a channel
  std::span<const std::uint16_t> words;  ///< (4 * width * height) 16 bits a channel
};

/// The images of a scan, with UVs for each face of the mesh.
struct Appearance {
  std::span<const float> uv;             ///< (6 F) u, v of the three corners; v = 1 is the upper edge of the image
  std::span<const std::int32_t> image;   ///< (F) the picture of each face; kNone: its colours
  std::span<const std::uint8_t> colors;  ///< (12 F) RGBA of the three corners; empty: none
  std::span<const std::uint8_t> known;   ///< (F) 0 where nothing is known: a face that covers a hole
  std::vector<Picture> pictures;
};

/// Further channels of a scan's materials, sampled at the same places as the colours.
struct MaterialLayers {
  std::vector<Appearance> images;    ///< roughness, emission and the like, from 0 to 255
  std::optional<Appearance> relief;  ///< tangent-space normals, green up; a face whose image is kNone has none
};

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

/// The images of the polygons: rows from the top, without the texels that have no colour. The last of several tiles is
/// at the top.
struct Texture {
  std::int32_t side = 0, height = 0;        ///< texels of a row, and rows of all tiles together: n = side * height
  Array<std::uint8_t> color;                ///< (4 n) RGBA
  Array<std::uint8_t> normal;               ///< (3 n) tangent-space normals, green up; empty if not requested
  std::vector<Array<std::uint8_t>> layers;  ///< (4 n) each, one for each of the images of MaterialLayers
  std::vector<PolygonTexels> texels;        ///< (Q)

  [[nodiscard]] PolygonTexels total() const {
    PolygonTexels sum;
    for (const PolygonTexels& polygon : texels) sum += polygon;
    return sum;
  }
};

/// Shows the scan on its polygons.
///
/// The faces of the polygon's region, and then those of adjacent regions, are drawn into its chart along directions
/// that lean from the polygon's normal, over edges below 78 degrees toward the normal of the adjacent polygon; a face
/// nearer to the plane hides others. There is no distance to choose. Places that no face is drawn to show the closest
/// face that looks the polygon's way. In a band along the edges the colours blend into those of the closest points,
/// which are the same from both sides of an edge. A pixel is the mean of 2 x 2 to 4 x 4 samples, as many as the density
/// of the scan's images needs; these are bilinear and never from a reduced image, since charts of scans lie close
/// together. Gutters continue the polygon's plane; the rest is flooded.
///
/// \param atlas  of these polygons
/// \param layers  made like the colours; the relief bends the scan's normals in the normal map
/// \throws InvalidInput  arrays that are not of this mesh, or an option out of its range
/// \throws Cancelled     nothing was made
/// Cost: about 0.1 us a sample and 0.5 us a face; memory: the images, 4 bytes a pixel, 100 bytes a face, and
/// while a polygon is baked 320 bytes for each face that it can show.
/// The result does not depend on the number of threads.
Texture bake(const Mesh& mesh, const Partition& partition, const PolygonMesh& polygons, const Atlas& atlas,
             const Appearance& appearance, const TextureOptions& options, Job& job, const MaterialLayers& layers = {});

/// The place of the scan that each texel shows: rows from the top.
struct BakeMap {
  std::int32_t side = 0, rows = 0;  ///< texels of a row, and number of rows: n = side * rows
  Array<std::int32_t> polygon;      ///< (n) the polygon a texel's centre lies in; kNone: gutter and the rest
  Array<std::int32_t> face;         ///< (n) of the mesh; kNone without a face
  Array<float> barycentric;         ///< (2 n) weights of the face's corners 1 and 2
};

/// The map by which `bake` samples colours, with one sample at the centre of each texel: for other layers.
/// In the half of the band that is nearer to an edge it holds the closest point.
BakeMap bake_map(const Mesh& mesh, const Partition& partition, const PolygonMesh& polygons, const Atlas& atlas,
                 const TextureOptions& options, Job& job);

}  // namespace isimp
