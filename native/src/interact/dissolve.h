#pragma once

#include <cstdint>

#include "edit.h"

namespace isimp {

/// Adds the faces of a region to the regions around it, relaxes the borders and removes its number.
/// \param face  a face of it, by graph index.
/// \return false if no region around can take them
bool dissolve(Edit& edit, std::int32_t region, std::int32_t face, Job& job);

}  // namespace isimp
