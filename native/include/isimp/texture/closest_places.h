#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// A place on the scan for each corner of polygons.
struct CornerPlaces {
  std::vector<std::int32_t> face;  ///< (L) of the mesh; kNone where no face is known
  std::vector<float> barycentric;  ///< (2 L) weights of the face's corners 1 and 2
};

/// The closest place to each corner on the faces of its polygon's own region; values on the scan are transferred with
/// it. Among equally close faces the first one counts. Corners of a region without a known face take the closest one of
/// all.
///
/// \param group  (F) if given, each polygon takes places of one group only: the group with most of its region's area.
///               Islands of a UV map are such groups: a place in another island has no meaning for the polygon's UVs.
///               Empty: one
/// \param known  (F) 0 for a face without values, such as a cover of a hole; empty: all have values
/// \throws InvalidInput  arrays that do not belong together
/// Cost: about 5 ns for each corner of a polygon and face of its region, on all threads together.
CornerPlaces closest_places(const Mesh& mesh, const Partition& partition, const PolygonMesh& polygons,
                            std::span<const std::uint8_t> known, std::span<const std::int32_t> group,
                            std::int32_t threads, Job& job);

}  // namespace isimp
