#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace isimp {

/// One kind of repair that `clean` made: its count and first places.
struct Repair {
  std::string what;                 ///< a key such as "duplicate_faces"
  std::int64_t count = 0;           ///< number of faces, edges or vertices, depending on the key
  std::vector<std::int32_t> where;  ///< the caller's indices of the first few (at most 16)
};

using RepairReport = std::vector<Repair>;

/// Properties of a mesh, and the changes that led to it from the caller's arrays.
struct MeshReport {
  std::int32_t vertices = 0, faces = 0;
  std::int32_t components = 0;
  std::int32_t closed_components = 0;
  std::int64_t border_edges = 0;
  std::int32_t border_loops = 0;
  std::int64_t euler = 0;  ///< used vertices - edges + faces
  std::int32_t zero_area_faces = 0;
  std::int32_t unused_vertices = 0;
  double area = 0.0;      ///< scene units squared; faces that count as without area add nothing
  double diagonal = 0.0;  ///< diagonal of the bounding box, scene units
  bool closed = false;    ///< without a border
  double cell = 0.0;      ///< of the grid whose stair steps were smoothed, scene units; 0: none
  RepairReport repairs;   ///< empty after Mesh(...)
};

}  // namespace isimp
