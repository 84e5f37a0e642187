#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "isimp/core/array.h"
#include "isimp/core/job.h"
#include "isimp/core/types.h"

namespace isimp {

/// Polygons with any number of corners, as in a file: they may be non-manifold, duplicate or degenerate.
struct PolygonSoup {
  std::vector<Vec3> vertices;      ///< (V) any numbers, including NaN
  Array<std::int32_t> loops;       ///< (L) vertex of each corner, in [0, V), polygon after polygon
  Array<std::int32_t> loop_start;  ///< (Q) first corner of each polygon in `loops`; its end is the next one's start

  [[nodiscard]] std::int32_t polygon_count() const { return static_cast<std::int32_t>(loop_start.size()); }
  [[nodiscard]] std::span<const std::int32_t> polygon(std::int32_t q) const;

  /// \throws InvalidInput  a corner's vertex does not exist, or `loop_start` does not rise from 0 to at most L
  void check() const;
};

/// A number of each vertex or face in a file.
struct Column {
  std::string name;
  std::string kind;  ///< its type in the file, as numpy writes it: "u1", "f4"
  std::vector<double> values;
};

/// The content of a file besides its geometry.
struct Columns {
  std::vector<std::string> names;         ///< set by the caller: the properties of PLY to read
  std::vector<Column> vertices;           ///< (V) numbers each; OBJ: red, green and blue if each vertex has them
  std::vector<Column> faces;              ///< (Q) numbers each; none in a file with triangle strips
  std::optional<std::vector<double>> uv;  ///< (L, 2) of each corner (PLY: from "texcoord"); zeros where it has none
  std::vector<std::string> files;         ///< PLY: textures that comments name; OBJ: material libraries
  std::vector<std::pair<std::int32_t, std::string>> materials;  ///< OBJ: each name with the first face behind it
  /// Content that the reader skipped, each name once. PLY: properties of vertices and faces, and other elements with
  /// rows; OBJ: keywords other than o, g and s; OFF: "C" (colours), "N" (normals), "ST" (texture coordinates); STL: "C".
  std::vector<std::string> skipped;
};

/// Reads a mesh file: PLY (text, binary of either byte order), OBJ, STL (text, binary) or OFF (text). The extension, in
/// upper or lower case, determines the format.
///
/// Polygons keep the file's order and number, broken ones too (a vertex named twice, fewer than three corners), so that
/// labels can be returned for the file's faces. Normals and the like are skipped.
/// Coordinates keep the file's precision. STL has no shared vertices: corners at equal positions become one vertex,
/// corners with NaN do not. A file without faces (a point cloud) gives no polygons. Triangle strips of PLY
/// (element tristrips) give their triangles. Data from a pipe is read to its end.
///
/// \throws FileError  missing, a folder, not readable, of another kind, damaged or cut short, an index out of range,
///                    more than 2^31 - 1 vertices or corners; the message names the file, the place in it and the
///                    expected content
/// \throws Cancelled  polled at least every 50 ms of work and while it waits for a pipe, not while the system waits for
///                    the disk
/// \param columns    filled if not null; STL and OFF have `skipped` only
/// \param threads    0: as many as there are cores; the result does not depend on it. They share the reading from the
///                   disk, and in binary PLY files the vertices and stretches of faces with equal numbers of corners
/// Cost: O(bytes). The file is held in memory meanwhile. A million faces of binary PLY take about 35 ms of processor time.
PolygonSoup read_polygons(const std::filesystem::path& path, Job& job, std::int32_t threads = 0,
                          Columns* columns = nullptr);

/// Writes polygons as binary PLY (little-endian, places as double) or OBJ (shortest decimals that give the same double
/// back), depending on the extension. The file appears whole or not at all: it is written next to its place under
/// another name and then moved there. It replaces an older file of that name and takes its permissions. A link stays a
/// link, and the file that it leads to is replaced. Pipes and devices are written to directly.
///
/// \param loop_start  (Q) first corner of each polygon in `loops`, rising from 0
/// \throws FileError     another extension, or a file that is read-only, or the place can't be written; nothing is
///                       left behind
/// \throws InvalidInput  an index out of range or a polygon of fewer than three corners
/// \throws Cancelled     nothing is left behind
void write_polygons(const std::filesystem::path& path, std::span<const Vec3> vertices,
                    std::span<const std::int32_t> loops, std::span<const std::int32_t> loop_start, Job& job);

/// Whether all polygons are triangles: `loops` then holds them one after another.
bool are_triangles(const PolygonSoup& soup, Job& job);

/// Triangles that fill polygons, without new vertices.
struct Triangulation {
  std::vector<Triangle> triangles;           ///< (F) wound as their polygon
  std::vector<std::int32_t> source_polygon;  ///< (F) rising
};

/// Cuts each polygon of n corners into n - 2 triangles by ears in the plane that fits it best. The triangles of a
/// concave polygon do not overlap if the polygon does not. A polygon with fewer than three corners gives no triangles;
/// one without area, with NaN or that crosses itself gives n - 2 triangles of some kind.
///
/// Cost: about O(n log n) for a polygon of n corners, 0.1 s for 50,000; the search for ears is bounded, so that
/// polygons that cross themselves take no more than some times that. Polled at least every 50 ms.
Triangulation triangulate(const PolygonSoup& soup, Job& job);

}  // namespace isimp
