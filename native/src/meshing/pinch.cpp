#include <algorithm>
#include <utility>

#include "discs.h"

namespace isimp::meshing {
namespace {

/// A hand-over of more faces than this is no small change of the regions any more.
constexpr std::size_t kLargestSector = 8;

/// Faces in a row round a vertex that have the same label.
struct Sector {
  std::int32_t label;
  std::vector<std::int32_t> faces;
};

struct Fan {
  std::vector<Sector> sectors;
  bool closed = false;  ///< the last one is followed by the first
};

Fan sectors_of(const Labels& labels, std::int32_t vertex) {
  Fan fan;
  for_each_leaving(labels.mesh, vertex, [&](std::int32_t h) {
    const std::int32_t l = labels.label[h / 3];
    if (fan.sectors.empty() || fan.sectors.back().label != l) fan.sectors.push_back({l, {}});
    fan.sectors.back().faces.push_back(h / 3);
  });
  fan.closed = labels.mesh.opposite(labels.mesh.vertex_halfedge()[vertex]) != kNone;
  if (fan.closed && fan.sectors.size() > 1 && fan.sectors.front().label == fan.sectors.back().label) {
    Sector& first = fan.sectors.front();
    first.faces.insert(first.faces.begin(), fan.sectors.back().faces.begin(), fan.sectors.back().faces.end());
    fan.sectors.pop_back();
  }
  return fan;
}

struct HandOver {
  const Sector* sector;
  std::int32_t to;
};

std::vector<HandOver> hand_overs(const Fan& fan) {
  std::vector<HandOver> result;
  const auto n = static_cast<int>(fan.sectors.size());
  for (int i = 0; i < n; ++i)
    for (const int step : {-1, 1}) {
      int j = i + step;
      if (fan.closed) j = (j + n) % n;
      if (j < 0 || j >= n || j == i || fan.sectors[i].faces.size() > kLargestSector) continue;
      if (fan.sectors[i].label != fan.sectors[j].label) result.push_back({&fan.sectors[i], fan.sectors[j].label});
    }
  std::stable_sort(result.begin(), result.end(), [](const HandOver& a, const HandOver& b) {
    return a.sector->faces.size() < b.sector->faces.size();
  });
  return result;
}

}  // namespace

std::vector<std::int32_t> hand_over_sector(Cutter& cutter, std::int32_t vertex) {
  Labels& labels = cutter.labels;
  const Fan fan = sectors_of(labels, vertex);
  for (const auto& [sector, to] : hand_overs(fan)) {
    const std::int32_t from = sector->label;
    std::vector<std::int32_t> giver = labels.faces_of(from), taker = labels.faces_of(to);
    if (giver.size() <= sector->faces.size()) continue;
    const std::int32_t before = labels.shape(giver).defect() + labels.shape(taker).defect();
    for (const std::int32_t f : sector->faces) labels.label[f] = to;
    std::erase_if(giver, [&](std::int32_t f) { return labels.label[f] != from; });
    taker.insert(taker.end(), sector->faces.begin(), sector->faces.end());
    if (labels.shape(giver, true).defect() + labels.shape(taker, true).defect() < before) {
      labels.pieces[from].face = giver[0];
      labels.touched.insert(labels.touched.end(), {from, to});
      return {from, to};
    }
    for (const std::int32_t f : sector->faces) labels.label[f] = from;
  }
  return {};
}

}  // namespace isimp::meshing
