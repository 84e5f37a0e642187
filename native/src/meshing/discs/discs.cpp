#include "discs/discs.h"

#include <algorithm>
#include <utility>

#include "isimp/core/sorted.h"

namespace isimp::meshing {
namespace {

// tuned holes
/// Loops, and two for a handle, beyond which a chart is parted by the directions its faces look in. Then each wall of a
/// hole is a polygon. Other cuts give half to a third as many polygons, but repairing them takes a time that grows with
/// the square of the holes.
constexpr std::size_t kManyOpenings = 24;
/// Openings per region of the mesh beyond which all charts are parted by directions, as a chart that is not parted
/// would not fit its neighbours.
constexpr double kOpeningsARegion = 4;
constexpr double kOfFlat = 2;  ///< openings per region if all sides are planes, so that walls are known
/// limit: handles that are cut one by one, each in time for all faces of the chart. A chart with more is halved first.
constexpr std::int32_t kFewHandles = 64;

/// Two faces of the chart in different sectors of a vertex where it touches itself.
std::array<std::int32_t, 2> faces_at_pinch(const Labels& labels, std::int32_t chart, std::int32_t vertex) {
  std::vector<std::int32_t> first;
  for_each_leaving(labels.mesh, vertex, [&](std::int32_t h) {
    if (labels.label[h / 3] == chart && !labels.inner(h)) first.push_back(h / 3);
  });
  if (first.size() < 2 || first[0] == first[1]) return {kNone, kNone};
  return {first[0], first[1]};
}

/// Cuts a chart that is no disc. The new charts have the last labels.
void cut(Cutter& cutter, std::int32_t chart, const Shape& shape, Job& job) {
  if (shape.pinches > 0) {
    bisect(cutter, chart, Cause::pinch, faces_at_pinch(cutter.labels, chart, shape.pinch_vertex));
    return;
  }
  const std::size_t openings = shape.loops.size() + 2 * static_cast<std::size_t>(shape.genus);
  if (openings > kManyOpenings && cut_by_direction(cutter, chart) > 0) return;
  if (shape.genus == 0 && shape.loops.size() > 1 && cut_wall(cutter, chart, shape, job) > 0) return;
  if (shape.genus == 0 && shape.loops.size() > 1 && cut_holes(cutter, chart, shape, job) > 0) return;
  if (shape.genus > 0 && shape.genus <= kFewHandles && cut_handles(cutter, chart, shape, job) > 0) return;
  bisect(cutter, chart, shape.genus > 0 ? Cause::handle : shape.loops.empty() ? Cause::closed : Cause::hole);
}

}  // namespace

double openings_of(const Mesh& mesh) {
  const MeshReport& r = mesh.report();
  const double handles = (2.0 * r.components - r.border_loops - static_cast<double>(r.euler)) / 2;
  return r.border_loops + std::max(0.0, handles);
}

bool is_perforated(const Cutter& cutter, std::int32_t regions, const Job& job) {
  const double openings = openings_of(cutter.labels.mesh);
  return openings > kOpeningsARegion * regions || (openings > kOfFlat * regions && has_flat_sides(cutter, job));
}

void part_walls(Cutter& cutter, const Job& job) {
  // The rest of a cut may have directions whose share of the whole chart was too small to be found.
  for (std::int32_t l = 0; l < cutter.labels.chart_count(); ++l) {
    job.poll();
    while (cut_by_direction(cutter, l) > 0) {
    }
  }
  cutter.labels.touched.clear();
}

void make_discs(Cutter& cutter, std::vector<std::int32_t> todo, std::map<std::int32_t, Disc>& found, Job& job) {
  while (!todo.empty()) {
    job.poll();
    const std::int32_t chart = todo.back();
    todo.pop_back();
    std::vector<std::int32_t> faces = cutter.labels.faces_of(chart);
    Shape shape = cutter.labels.shape(faces);
    if (shape.is_disc()) {
      found[chart] = {std::move(faces), std::move(shape.loops[0])};
      continue;
    }
    const std::int32_t before = cutter.labels.chart_count();
    cut(cutter, chart, shape, job);
    todo.push_back(chart);
    for (std::int32_t l = before; l < cutter.labels.chart_count(); ++l) todo.push_back(l);
  }
}

namespace {

/// The chart with the most faces, kNone if none has two.
std::int32_t largest_of(Labels& labels, std::span<const std::int32_t> charts) {
  std::int32_t largest = kNone;
  std::size_t most = 1;
  for (const std::int32_t l : charts) {
    const std::size_t faces = labels.faces_of(l).size();
    if (faces <= most) continue;
    most = faces;
    largest = l;
  }
  return largest;
}

}  // namespace

void split_closed_components(Cutter& cutter, std::int32_t least, std::map<std::int32_t, Disc>& found, Job& job) {
  Labels& labels = cutter.labels;
  const Mesh& mesh = labels.mesh;
  std::vector<bool> open(mesh.component_count(), false);
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); ++h)
    if (mesh.opposite(h) == kNone) open[mesh.component()[h / 3]] = true;
  std::vector<std::vector<std::int32_t>> of(mesh.component_count());
  for (std::int32_t l = 0; l < labels.chart_count(); ++l) of[mesh.component()[labels.charts[l].face]].push_back(l);
  for (std::size_t c = 0; c < of.size(); ++c) {
    while (!open[c] && !of[c].empty() && static_cast<std::int32_t>(of[c].size()) < least) {
      const std::int32_t largest = largest_of(labels, of[c]);
      if (largest == kNone) break;
      const std::int32_t before = labels.chart_count();
      bisect(cutter, largest, Cause::closed);
      std::vector<std::int32_t> changed{largest};
      for (std::int32_t l = before; l < labels.chart_count(); ++l) changed.push_back(l);
      make_discs(cutter, changed, found, job);
      for (std::int32_t l = before; l < labels.chart_count(); ++l) of[c].push_back(l);
    }
  }
}

}  // namespace isimp::meshing
