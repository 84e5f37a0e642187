#pragma once

#include "isimp/mesh/face_graph.h"
#include "isimp/partition/metric.h"
#include "tests.h"

namespace isimp::graphs {

/// The sum of one face with this normal times its area.
inline RegionSum node(double x, double y, double z = 0) {
  RegionSum s;
  s.x = x;
  s.y = y;
  s.z = z;
  s.faces = 1;
  return s;
}

/// A strip of faces of equal area, each joined to the one before, with normals at these angles in the x-y plane.
inline FaceGraph strip(const std::vector<double>& degrees) {
  FaceGraph g;
  const auto n = static_cast<std::int32_t>(degrees.size());
  for (std::int32_t i = 0; i < n; ++i) {
    const double a = degrees[i] * 3.14159265358979 / 180;
    g.faces.push_back(
        {static_cast<float>(std::cos(a)), static_cast<float>(std::sin(a)), 0, 1.0F / static_cast<float>(n)});
    g.neighbours.push_back({i > 0 ? i - 1 : n, i + 1, n});
    g.mesh_face.push_back(i);
    g.graph_face.push_back(i);
  }
  g.faces.push_back({});
  g.neighbours.push_back({n, n, n});
  g.area = 1;
  return g;
}

}  // namespace isimp::graphs
