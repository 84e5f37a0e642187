#pragma once

#include <optional>

#include "formats.h"

namespace isimp::detail {

/// Reads a plain OBJ file on all threads: lines that begin with "v " or "f ", all faces with as many corners, numbers
/// of vertices counted from 1. Nothing for any other file, a damaged one among them: read_obj then says what is wrong.
/// Other lines are skipped. The lines are counted first, so no array is larger than it must be.
std::optional<PolygonSoup> read_obj_lines(const FileText& file, const Threads& threads, Job& job);

}  // namespace isimp::detail
