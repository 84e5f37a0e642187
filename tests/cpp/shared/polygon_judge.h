#pragma once

#include "isimp/mesh/mesh.h"
#include "isimp/meshing/polygonize.h"
#include "tests.h"

namespace isimp::judge {

using Loop = std::vector<std::int32_t>;

/// The vertices of each polygon in turn.
std::vector<Loop> polygons_of(const PolygonMesh& mesh);

/// Properties of a polygon mesh, found from its arrays alone, by other means than the engine's own checks.
struct Figures {
  std::string
      defects;  ///< "" if every edge is used once or twice and in opposite directions, every vertex has one fan,
                ///< no polygon repeats a vertex or another polygon or has no area, no vertex is unused, ...
  std::int64_t euler = 0, border_edges = 0, border_loops = 0, components = 0;
  double area = 0;
  double bend_max = 0;  ///< largest distance of a corner from its polygon's plane
};

Figures look_at(const PolygonMesh& mesh);

/// look_at(), and the same Euler characteristic, components and border loops as the part of `scan` that has a region.
/// \return "" or the defect
std::string defects_against(const PolygonMesh& mesh, const Mesh& scan, const Partition& partition);

/// The polygons of a partition; the test fails if they have a defect.
PolygonMesh sound(const Mesh& scan, const Partition& partition);

}  // namespace isimp::judge
