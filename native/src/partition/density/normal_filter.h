// Filters the normals of a scan (Zheng, Fu, Au, Tai: Bilateral normal filtering for mesh denoising, 2011).
#pragma once

#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/mesh/face_graph.h"

namespace isimp {

// tuned found
inline constexpr int kFilterPasses = 8;  // of filtered_faces

/// Median difference |n - n'| of the normals of neighbouring faces: mostly the effect of noise, less of curvature.
/// Cost: O(F).
double median_bend(const FaceGraph& graph);

/// The faces with their normals averaged over neighbours whose normals are alike, which removes noise and keeps
/// creases.
///
/// Each pass adds to a face's normal its neighbours' normals, weighted by area and by exp(-|n - n'|^2 / (2 range^2)).
/// \param range   difference of normals beyond which two faces do not mix; filter_range(median_bend(graph)) fits most.
///                A range under strong noise, which spans creases too, falls to that of the normals after half of the
///                passes
/// \return (n + 1) as graph.faces: areas unchanged
/// Cost: O(passes * F).
/// Source: bilateral filtering of normals, as in Zheng, Fu, Au, Tai 2011.
Array<FaceRecord> filtered_faces(const FaceGraph& graph, int passes, double range, const Threads& threads, Job& job);

inline double filter_range(double bend) { return bend > 0.01 ? 2 * bend : 0.02; }

}  // namespace isimp
