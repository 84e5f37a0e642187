#pragma once

#include <cstdint>
#include <optional>

#include "isimp/core/job.h"
#include "isimp/texture/unwrap.h"
#include "layout.h"

namespace isimp::detail {

/// An atlas of the polygons of a layout, without places.
Atlas empty_atlas(const Layout& layout, const Room& room, double scale);

/// Puts polygon q of a packed layout into an atlas, as its polygon `to` whose corners begin at `begin`.
void put(const Layout& layout, const Packing& packing, std::int32_t q, Atlas& atlas, std::int32_t to,
         std::int32_t begin);

/// Whether an earlier atlas has the requested room.
bool has_room_of(const AtlasOptions& options, const Layout& whole, const Atlas& atlas, const Room& room);

/// An atlas with polygons at their places of an earlier one, and the others in the room between. Empty if none is kept,
/// or if the others do not fit between them, unfolded or not.
/// \param whole  the layout of all polygons, unfolded
std::optional<Atlas> rearrange(const PolygonMesh& polygons, const AtlasOptions& options, const Layout& whole,
                               const EarlierAtlas& earlier, const Room& room, Job& job);

}  // namespace isimp::detail
