#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "isimp/mesh/face_graph.h"

namespace isimp {

/// The sums of the faces of a region: enough for its normal, its error, and the exact change when a face moves.
///
/// With S the sum of area * normal, the error of the region under its best normal S / |S| is
/// sum of area * |n - S / |S||^2 = sum of area * (1 + |n|^2) - 2 |S|. All areas are shares of the whole surface's.
struct RegionSum {
  double x = 0, y = 0, z = 0;  ///< sum of area * normal
  double weight = 0;           ///< sum of area * (1 + |normal|^2); normals are unit only up to float rounding
  std::int32_t faces = 0;
  std::int32_t unused = 0;  ///< in place of padding, so that equal sums are equal bytes in pickles

  [[nodiscard]] double length() const { return std::sqrt(x * x + y * y + z * z); }
  [[nodiscard]] double error() const { return std::max(0.0, weight - 2 * length()); }
  /// The best normal. Where the faces' normals cancel, all normals are equally good; without area there is none.
  [[nodiscard]] Vec3 normal() const {
    const double norm = length();
    if (norm > 0) return {x / norm, y / norm, z / norm};
    return weight > 0 ? Vec3(0, 0, 1) : Vec3(0, 0, 0);
  }

  void add(const FaceRecord& f) { accumulate(f, f.area, 1); }
  void remove(const FaceRecord& f) { accumulate(f, -static_cast<double>(f.area), -1); }
  void add(const RegionSum& s) {
    x += s.x;
    y += s.y;
    z += s.z;
    weight += s.weight;
    faces += s.faces;
  }

 private:
  void accumulate(const FaceRecord& f, double area, std::int32_t count) {
    const double nx = f.nx, ny = f.ny, nz = f.nz;
    x += area * nx;
    y += area * ny;
    z += area * nz;
    weight += area * (1 + nx * nx + ny * ny + nz * nz);
    faces += count;
  }
};

/// Half of the growth of the error when two regions are merged: the length that their sums of area * normal lose.
///
/// \param a, b     have members x, y, z: the sums
/// \param lengths  |a| + |b|, in the precision of the result
template <class A, class B, class T>
T lost_length(const A& a, const B& b, T lengths) {
  const T x = a.x + b.x, y = a.y + b.y, z = a.z + b.z;
  return lengths - std::sqrt(x * x + y * y + z * z);
}

/// Growth of the error when two regions are merged.
inline double merge_cost(const RegionSum& a, const RegionSum& b) {
  return 2 * lost_length(a, b, a.length() + b.length());
}

/// L2,1: the squared difference of the normals. The area is a weight in the fit and the total, not in the order of the
/// flooding, as in the thesis: slivers then neither win nor become seeds.
struct NormalMetric {
  struct Proxy {
    float x = 0, y = 0, z = 0;  ///< unit normal; zero for a region without area
  };
  using Sum = RegionSum;

  static float error(const FaceRecord& f, const Proxy& p) {
    const float x = f.nx - p.x, y = f.ny - p.y, z = f.nz - p.z;
    return x * x + y * y + z * z;
  }
  static Proxy proxy_of(const FaceRecord& f) { return {f.nx, f.ny, f.nz}; }
  static Proxy fit(const Sum& s) {
    const Vec3 normal = s.normal();
    return {static_cast<float>(normal.x()), static_cast<float>(normal.y()), static_cast<float>(normal.z())};
  }
};

}  // namespace isimp
