#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "isimp/mesh/mesh.h"

/// Small meshes whose right answers are known.
namespace isimp::shapes {

struct Arrays {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
};

/// The unit cube, each side n by n squares of two triangles: 12 n^2 faces, 6 n^2 + 2 vertices.
Arrays cube(int n = 1);
/// The unit square in the plane z = 0, n by n squares of two triangles, open.
Arrays plane(int n = 1);
/// The sphere of radius 1: an icosahedron whose faces are split in four `levels` times, 20 * 4^levels faces.
Arrays sphere(int levels);
/// A ring of radius 1 around the z axis with a tube of radius r, nu by nv squares of two triangles, genus 1.
Arrays torus(int nu, int nv, double r = 0.4);
/// A closed box of w by h unit cells with holes through the open ones. Corners that no cell has are there too.
Arrays perforated(int w, int h, double thickness, const std::function<bool(int x, int y)>& is_open);
Arrays scaled(Arrays a, double by);
Arrays moved(Arrays a, const Vec3& by);
/// Two meshes as one, `b` moved by `offset`.
Arrays both(const Arrays& a, const Arrays& b, const Vec3& offset);
/// The same surface with its faces in another order, drawn by `seed`.
Arrays shuffled(const Arrays& a, std::uint32_t seed);
/// Every vertex moved by normal noise of standard deviation `sigma`, drawn by `seed`.
Arrays noisy(const Arrays& a, double sigma, std::uint32_t seed);
/// Every vertex moved half-way to the mean of its neighbours, `rounds` times: edges and corners are rounded.
Arrays smoothed(const Arrays& a, int rounds);

Mesh mesh(const Arrays& a);
Vec3 middle(const Mesh& mesh, std::int32_t face);
/// The label of each face, by its middle.
std::vector<std::int32_t> labels(const Mesh& mesh, const std::function<std::int32_t(const Vec3&)>& label);

}  // namespace isimp::shapes
