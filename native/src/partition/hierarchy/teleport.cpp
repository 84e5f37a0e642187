#include "hierarchy/teleport.h"

#include <algorithm>
#include <limits>
#include <queue>
#include <tuple>
#include <utility>

#include "borders/local.h"
#include "hierarchy/region_graph.h"
#include "isimp/core/check.h"

namespace isimp {
namespace {

constexpr int kTeleportSweeps = 200;  // limit: sweeps of the borders after a round; a face may have to grow over a side
// tuned unrecorded
constexpr double kGainMargin = 0.02;  // a move must gain this share more than it costs
constexpr std::int64_t kRenewals =
    16;  // limit: faces in repeated splits, in all, as a multiple of the surface's: one large
         // region with hundreds around it would try for long
constexpr double kLeastFall = 1e-3;  // share of the error: the least fall in a round that is worth another
constexpr double kLeastGain = 1e-7;  // rounding: share of the whole area: less is rounding
/// limit: faces of all regions that were split, as a multiple of the surface's: the last round begins below it. Else few
/// regions that share the walls of thousands of holes would exchange these one by one.
constexpr std::int64_t kMoves = 24;

/// limit: from so many regions on both limits shrink with their number: the error can fall but little by each of many.
constexpr double kFewRegions = 30;
constexpr double kLeastWork = 0.5;  // limit: the least of these, as a multiple of the surface's faces
constexpr int kVain = 3;            // limit: neighbours in a row without gain that end the tries for a region

}  // namespace

Teleport::Teleport(const FaceGraph& graph, const Components& components, Regions& regions,
                   std::vector<std::int32_t> component, Relaxation<GraphLabels>& relaxation)
    : graph_(graph),
      components_(components),
      regions_(regions),
      labels_{regions.label.data()},
      component_(std::move(component)),
      count_(components.all.size(), 0),
      relaxation_(relaxation) {
  for (std::int32_t r = 0; r < regions.count(); ++r) ++count_[component_of(r)];
}

/// Some face of a region: mostly the stored one, which lies deep inside and so seldom moves away.
std::int32_t Teleport::face_of(std::int32_t region, Job& job) {
  if (some_face_.empty()) some_face_ = nearest_faces(graph_, regions_, job);
  some_face_.resize(regions_.sum.size() + 1, graph_.size());
  if (labels_.get(some_face_[region]) != region)
    for (std::int32_t i = 0; i < graph_.size(); ++i)
      if (const std::int32_t r = labels_.get(i); r >= 0) some_face_[r] = i;
  return some_face_[region];
}

void Teleport::push_borders(std::span<const std::int32_t> faces) {
  for (const std::int32_t face : faces) {
    relaxation_.push_if_border(face);
    for (const std::int32_t j : graph_.neighbours[face])
      if (j != graph_.size()) relaxation_.push_if_border(j);
  }
}

/// Splits a region in its labels only.
/// \return by how much the error falls; below 0 if it can't be split
double Teleport::split(std::int32_t region, std::int32_t fresh, Job& job) {
  faces_ = take_out(graph_, labels_, face_of(region, job));
  move_work_ -= static_cast<std::int64_t>(faces_.size());
  if (faces_.size() < 2) {
    undo_split(region);
    return -1.0;
  }
  const Halves halves = split_in_two(graph_, labels_, faces_, regions_.sum[region], {region, fresh});
  halves_[0] = halves.sum[0];
  halves_[1] = halves.sum[1];
  return split_gain(regions_.sum[region], halves);
}

void Teleport::undo_split(std::int32_t region) {
  for (const std::int32_t face : faces_) labels_.set(face, region);
}

/// Completes the last split: updates the sums, and pushes the border between the halves for relaxing.
void Teleport::accept_split(std::int32_t region, std::int32_t fresh) {
  if (fresh == regions_.count()) {
    regions_.sum.emplace_back();
    if (!component_.empty()) component_.push_back(component_[region]);
  } else if (!component_.empty()) {
    component_[fresh] = component_[region];
  }
  ISIMP_ASSERT(halves_[0].faces > 0 && halves_[1].faces > 0, "both halves have faces");
  ++count_[component_of(region)];
  regions_.sum[region] = halves_[0];
  regions_.sum[fresh] = halves_[1];
  some_face_.resize(std::max(some_face_.size(), regions_.sum.size()), graph_.size());
  for (const std::int32_t face : faces_) some_face_[labels_.get(face)] = face;
  push_borders(faces_);
}

bool Teleport::fill_up(Job& job) {
  // The worst region of a component that needs more regions comes first, else the worst of all; of flat ones the
  // largest.
  using Rank = std::tuple<bool, double, std::int32_t, std::int32_t>;
  const auto rank = [&](std::int32_t r) {
    const double error = regions_.sum[r].error();
    const bool wanted = count_[component_of(r)] < components_.all[component_of(r)].need;
    return Rank(wanted, error > kLeastGain ? error : 0.0, regions_.sum[r].faces, -r);
  };
  std::int32_t wanting = 0;  // regions that components lack
  for (std::size_t c = 0; c < count_.size(); ++c) wanting += std::max(0, components_.all[c].need - count_[c]);
  if (wanting == 0 && regions_.count() >= components_.regions()) return false;
  std::priority_queue<Rank> order;
  for (std::int32_t r = 0; r < regions_.count(); ++r) order.push(rank(r));
  while (wanting > 0 || regions_.count() < components_.regions()) {
    job.poll();
    const Rank first = order.top();
    order.pop();
    const std::int32_t worst = -std::get<3>(first);
    if (regions_.sum[worst].faces < 2) continue;
    if (rank(worst) != first) {  // its component has its need by now
      order.push(rank(worst));
      continue;
    }
    const std::int32_t fresh = regions_.count();
    wanting -= std::get<0>(first) ? 1 : 0;
    split(worst, fresh, job);
    accept_split(worst, fresh);
    order.push(rank(worst));
    order.push(rank(fresh));
  }
  relaxation_.refit();
  relaxation_.run(kTeleportSweeps, job);
  return true;
}

std::vector<Teleport::Pair> Teleport::cheapest_pairs() const {
  std::vector<Pair> pairs;
  for (const auto& [u, v] : neighbouring_regions(graph_, regions_.label, relaxation_.pushed()))
    if (u < v) pairs.push_back({merge_cost(regions_.sum[u], regions_.sum[v]), u, v});
  std::sort(pairs.begin(), pairs.end(),
            [](const Pair& a, const Pair& b) { return std::tie(a.cost, a.u, a.v) < std::tie(b.cost, b.u, b.v); });
  return pairs;
}

std::vector<std::int32_t> Teleport::worst_regions() const {
  std::vector<std::pair<double, std::int32_t>> order;
  order.reserve(regions_.sum.size());
  for (std::int32_t r = 0; r < regions_.count(); ++r) order.emplace_back(-regions_.sum[r].error(), r);
  std::sort(order.begin(), order.end());
  std::vector<std::int32_t> worst;
  worst.reserve(order.size());
  for (const auto& [unused, r] : order) worst.push_back(r);
  return worst;
}

void Teleport::merge(std::int32_t into, std::int32_t from, Job& job) {
  const std::vector<std::int32_t> faces = take_out(graph_, labels_, face_of(from, job));
  for (const std::int32_t face : faces) labels_.set(face, into);
  regions_.sum[into].add(regions_.sum[from]);
  --count_[component_of(from)];
  push_borders(faces);
}

/// Merges a region with a neighbour and splits the result again: an island of a side that belongs to the region grows
/// so.
bool Teleport::part_anew(std::int32_t region, std::int32_t other, Job& job) {
  const RegionSum one = regions_.sum[region], two = regions_.sum[other];
  const std::vector<std::int32_t> faces = take_out(graph_, labels_, face_of(other, job));
  for (const std::int32_t face : faces) labels_.set(face, region);
  regions_.sum[region].add(two);
  const double joining = regions_.sum[region].error() - one.error() - two.error();
  parted_gain_ = split(region, other, job);
  if (parted_gain_ - joining > kGainMargin * joining + kLeastGain) {
    --count_[component_of(region)];
    accept_split(region, other);
    return true;
  }
  undo_split(region);
  for (const std::int32_t face : faces) labels_.set(face, other);
  regions_.sum[region] = one;
  return false;
}

/// Merges a pair and splits a region elsewhere.
/// \param price  the least gain of the split
bool Teleport::move(const Pair& pair, std::int32_t region, double price, Job& job) {
  const std::int32_t spare = regions_.count();  // label of the new half until the merge has freed one
  tried_[region].error = regions_.sum[region].error();
  tried_[region].gain = split(region, spare, job);
  if (tried_[region].gain <= price) {
    undo_split(region);
    return false;
  }
  std::vector<std::int32_t> half;
  for (const std::int32_t face : faces_)
    if (labels_.get(face) == spare) half.push_back(face);
  merge(pair.u, pair.v, job);
  for (const std::int32_t face : half) labels_.set(face, pair.v);
  accept_split(region, pair.v);
  return true;
}

int Teleport::round(int tries, double least_ratio, Job& job) {
  const std::vector<Pair> pairs = cheapest_pairs();
  std::vector<bool> used(regions_.sum.size(), false);
  tried_.resize(regions_.sum.size());
  int moves = 0, failed = 0;
  auto cheapest = pairs.begin();
  for (const std::int32_t region : worst_regions()) {
    job.poll();
    if (used[region]) continue;
    const auto unused = [&](const Pair& p) { return !used[p.u] && !used[p.v]; };
    const auto free = [&](const Pair& p) {
      const std::int32_t c = component_of(p.u);
      const bool spare = count_[c] > components_.all[c].need || c == component_of(region);
      return unused(p) && p.u != region && p.v != region && spare;
    };
    cheapest = std::find_if(cheapest, pairs.end(), unused);
    const auto pair = std::find_if(cheapest, pairs.end(), free);
    if (cheapest == pairs.end() || failed >= tries) break;
    const double error = regions_.sum[region].error();
    const double price = cheapest->cost * (1 + kGainMargin) + kLeastGain;
    if (error <= price || error < least_ratio * cheapest->cost) break;  // nor can any that follows gain enough
    if (tried_[region].error == error && tried_[region].gain <= price) continue;
    if (cheapest->u == region || cheapest->v == region) {
      const std::int32_t other = cheapest->u + cheapest->v - region;
      if (part_anew(region, other, job)) {
        used[region] = used[other] = true;
        failed = 0;
        ++moves;
        continue;
      }
    }
    if (pair != pairs.end() && move(*pair, region, pair->cost * (1 + kGainMargin) + kLeastGain, job)) {
      used[pair->u] = used[pair->v] = used[region] = true;
      failed = 0;
      ++moves;
    } else {
      ++failed;
    }
  }
  if (moves == 0) return 0;
  relaxation_.refit();
  relaxation_.run(kTeleportSweeps, job);
  return moves;
}

/// The error above which a region is split again: far above the usual.
double Teleport::renewal_bound(const std::vector<std::int32_t>& worst, double least_ratio) const {
  return kLeastGain + least_ratio * regions_.sum[worst[worst.size() / 2]].error();
}

bool Teleport::worth_trying(const MergeGraph& pairs, double least_ratio) const {
  double cheapest = std::numeric_limits<double>::infinity();
  for (std::int32_t u = 0; u < pairs.size(); ++u)
    for (const std::int32_t v : pairs.around(u))
      if (u < v) cheapest = std::min(cheapest, merge_cost(regions_.sum[u], regions_.sum[v]));
  const std::vector<std::int32_t> worst = worst_regions();
  const double most = regions_.sum[worst.front()].error();
  return most > std::min(kLeastGain + least_ratio * cheapest, renewal_bound(worst, least_ratio));
}

/// Merges regions that are far worse than the usual with each of their neighbours in turn, and splits the result again.
/// That opens rings: a ring around another region can't yield face by face, since it would fall apart before it is
/// whole again.
int Teleport::renew(int tries, double least_ratio, Job& job) {
  const std::vector<std::int32_t> worst = worst_regions();
  const double bound = renewal_bound(worst, least_ratio);
  if (regions_.sum[worst.front()].error() <= bound) return 0;
  std::vector<std::vector<std::int32_t>> around(regions_.sum.size());
  for (const auto& [u, v] : neighbouring_regions(graph_, regions_.label, relaxation_.pushed())) around[u].push_back(v);
  std::vector<bool> used(regions_.sum.size(), false);
  int moves = 0, failed = 0;
  for (const std::int32_t region : worst) {
    const double error = regions_.sum[region].error();
    if (error <= bound || failed >= tries || renewal_work_ < 0) break;
    if (used[region] || tried_[region].renewed == error) continue;
    tried_[region].renewed = error;
    bool better = false;
    int vain = 0;  // neighbours in a row with which nothing but rounding was gained, as on flat ground with noise
    for (const std::int32_t other : around[region]) {
      job.poll();
      if (used[other]) continue;
      renewal_work_ -= regions_.sum[region].faces + regions_.sum[other].faces;
      if (renewal_work_ < 0) break;
      if (!part_anew(region, other, job)) {
        vain = parted_gain_ > kLeastGain ? 0 : vain + 1;
        if (vain >= kVain) break;
        continue;
      }
      used[region] = used[other] = better = true;
      break;
    }
    failed = better ? 0 : failed + 1;
    moves += better ? 1 : 0;
  }
  if (moves == 0) return 0;
  relaxation_.refit();
  relaxation_.run(kTeleportSweeps, job);
  return moves;
}

int Teleport::run(int tries, double least_ratio, Job& job) {
  int moves = 0, rounds = 0;
  const double few = std::min(1.0, kFewRegions / regions_.count());
  const auto work = [&](std::int64_t times) {
    return static_cast<std::int64_t>(std::max(kLeastWork, few * static_cast<double>(times)) * graph_.size());
  };
  renewal_work_ = work(kRenewals);
  move_work_ = work(kMoves);
  for (;;) {
    const Regions before = regions_;
    int made = round(tries, least_ratio, job);
    if (made == 0) made = renew(tries, least_ratio, job);
    if (made == 0) return moves;
    if (regions_.error() > (1 - kLeastFall) * before.error()) {  // the relaxation also weighs the borders' length
      if (regions_.error() > before.error()) {
        std::copy(before.label.begin(), before.label.end(), regions_.label.begin());
        regions_.sum = before.sum;
        relaxation_.refit();
      }
      return moves;
    }
    moves += made;
    if (move_work_ < 0) return moves;
    job.report(1 - 1 / (1 + 0.2 * ++rounds));  // the number of rounds is unknown
  }
}

}  // namespace isimp
