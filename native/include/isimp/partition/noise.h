#pragma once

#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/mesh/mesh.h"

namespace isimp {

/// The size of a surface: three times the root mean square distance of its points from their centroid, scene units.
///
/// About the length of the bounding box's diagonal, but it neither turns with the axes nor follows single vertices nor
/// changes when faces are split.
/// Cost: O(F).
double surface_size(const Mesh& mesh);

/// Length of an edge, were all faces equilateral and equal; scene units.
double mean_edge(const Mesh& mesh);

/// Standard deviation of the white noise in the vertices' positions, along the normal; scene units.
///
/// The umbrella operator r(v) = v - mean of the neighbours, applied twice, leaves only noise of a smooth surface. Its
/// part along the normal is computed at each vertex away from borders; the median makes creases count little. The
/// estimate is true within 10 % at noise that matters, up to 45 % too high at very weak noise. Smoothing makes noise at
/// neighbouring vertices alike, and such noise can't be distinguished from shape. From .06 of an edge's length on, the
/// remainder after one application must fit white noise too, and the remainder must not grow with the length of the
/// edges. Else it is the shape of a mesh with few faces, and the estimate is lowered. An estimate above half an edge's
/// length, or from fewer than 250 vertices, is taken for shape: 0. Where steps of a grid were smoothed, it is .12 of a
/// cell.
/// Cost: O(V + F).
double estimate_noise(const Mesh& mesh, const Threads& threads, Job& job);

// tuned noise
/// Noise of a scan, as a share of the mean edge: scans have .01 and more, CAD models .001 and less.
inline constexpr double kScanNoise = 0.005;

/// Whether `estimate_noise` is above a length, scene units.
/// Cost: O(1) where a sample of the vertices is clear, else that of `estimate_noise`.
bool is_noisier(const Mesh& mesh, double least, Job& job);

}  // namespace isimp
