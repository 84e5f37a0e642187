#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "files/file_text.h"
#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/mesh/io.h"

/// The file formats, each read by a few plain functions of our own.
///
/// OpenMesh 9 has readers and writers for all four, and its importer interface would take polygon soup, but they break
/// the promises of `isimp/mesh/io.h`, and no check before them could prevent it:
///  - places pass through float, so that a scan in map coordinates moves by up to half a metre; text with NaN ends the
///    reading without an error, and the rest of the file reads as zeros;
///  - OBJ and STL faces that name a vertex twice vanish, so that labels no longer fit the file's faces, and an STL
///    vertex with NaN becomes an arbitrary other one;
///  - damaged bytes end the process (a PLY property before any element: a wild write; an OBJ face "f /1": an
///    assertion that Debian's build keeps), hang it (a PLY header without its end), exhaust the memory (an OFF file
///    cut short) or give made-up faces (a comment in an OFF file: 32,573 of them);
///  - readers and writers are global objects with state, so that two threads can't read at once, and some messages
///    reach the process's error stream in spite of all settings;
///  - the PLY writer cuts the number of a polygon's corners to eight bits and places to float, the OBJ writer to float.
/// The tests read the files of this writer with OpenMesh and the other way round.
namespace isimp::detail {

/// Collects vertices and polygons, one by one or many at once, and refuses more than indices can count.
class SoupBuilder {
 public:
  SoupBuilder(const FileText& file, const Threads& threads) : file_(file), threads_(threads) {}
  void reserve(std::size_t vertices, std::size_t polygons);
  void add_vertex(const Vec3& p) {
    if (soup_.vertices.size() == kMostIndices) too_many("vertices");
    soup_.vertices.push_back(p);
  }
  void begin_polygon() {
    if (soup_.loops.size() == kMostIndices || soup_.loop_start.size() == kMostIndices) too_many("corners");
    soup_.loop_start.push_back(static_cast<std::int32_t>(soup_.loops.size()));
  }
  /// Any number: `finish` checks it, since some formats allow faces before their vertices.
  void add_corner(std::int64_t vertex) {
    if (soup_.loops.size() == kMostIndices) too_many("corners");
    soup_.loops.push_back(corner(vertex));
  }
  /// A vertex index for `loops`; one that does not fit becomes kOut, which the check refuses.
  static std::int32_t corner(std::int64_t vertex) {
    return vertex < 0 || vertex > static_cast<std::int64_t>(kMostIndices) ? kOut : static_cast<std::int32_t>(vertex);
  }
  /// Number of polygons with `corners` corners each that can still be added.
  [[nodiscard]] std::size_t room_for_polygons(std::size_t corners) const {
    const std::size_t starts = kMostIndices - soup_.loop_start.size();
    return corners == 0 ? starts : std::min(starts, (kMostIndices - soup_.loops.size()) / corners);
  }
  [[nodiscard]] std::size_t room_for_vertices() const { return kMostIndices - soup_.vertices.size(); }
  /// Adds vertices within that room, for the caller to set.
  std::span<Vec3> add_vertices(std::size_t count);
  /// Adds `count` polygons with `corners` corners each. The caller sets the corners, polygon after polygon.
  std::span<std::int32_t> add_polygons(std::size_t count, std::size_t corners);
  /// Removes the last `count` polygons, which have `corners` corners each.
  void drop_polygons(std::size_t count, std::size_t corners);
  [[nodiscard]] const std::vector<Vec3>& vertices() const { return soup_.vertices; }
  [[nodiscard]] std::size_t corners() const { return soup_.loops.size(); }
  [[nodiscard]] std::size_t polygons() const { return soup_.loop_start.size(); }
  /// Checks the indices.
  /// \param first_index  index of the first vertex in the format
  PolygonSoup finish(std::int32_t first_index, Job& job);

 private:
  static constexpr std::size_t kMostIndices = 0x7fffffff - 1;  // limit
  static constexpr std::int32_t kOut = 0x7fffffff;             // limit: replaces every number that no vertex can have
  [[noreturn]] void too_many(const char* what) const;

  const FileText& file_;
  const Threads& threads_;
  PolygonSoup soup_;
};

/// Polls in each piece of work, and reports how far the first one is, since the others are about as far.
inline void report_piece(Job& job, std::int32_t piece, double share) {
  if (piece == 0) {
    job.report(share);
  } else {
    job.poll();
  }
}

/// \param columns  see `read_polygons`
PolygonSoup read_ply(const FileText& file, Columns* columns, const Threads& threads, Job& job);
PolygonSoup read_obj(const FileText& file, Columns* columns, const Threads& threads, Job& job);
PolygonSoup read_stl(const FileText& file, Columns* columns, const Threads& threads, Job& job);
PolygonSoup read_off(const FileText& file, Columns* columns, const Threads& threads, Job& job);

}  // namespace isimp::detail
