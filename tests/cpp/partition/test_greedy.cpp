// Clusters with many others around them, against a version that compares all pairs before each merge.

#include "graphs.h"
#include "hierarchy/greedy.h"
#include "tests.h"

namespace isimp {
namespace {

using graphs::node;

using Borders = std::map<std::pair<std::int32_t, std::int32_t>, double>;

std::pair<std::int32_t, std::int32_t> pair_of(std::int32_t u, std::int32_t v) {
  return {std::min(u, v), std::max(u, v)};
}

struct Case {
  std::vector<RegionSum> sum;
  Borders border;  // by pair of neighbours, the lower one first
};

/// Some planes with many small nodes in a ring around each, like houses on the ground; some nodes lie between two.
/// \param away    share of the small nodes that face away from their plane, so that it gets smaller by them
/// \param length  largest border
Case houses(std::int32_t planes, std::int32_t around, double away, double length, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1), tilt(-0.4, 0.4);
  Case c;
  for (std::int32_t h = 0; h < planes; ++h) c.sum.push_back(node(0.3 * tilt(random), 0.3 * tilt(random), 1 + h));
  const auto join = [&](std::int32_t u, std::int32_t v) { c.border[pair_of(u, v)] += length * unit(random); };
  for (std::int32_t h = 0; h + 1 < planes; ++h) join(h, h + 1);
  for (std::int32_t h = 0; h < planes; ++h)
    for (std::int32_t k = 0; k < around; ++k) {
      const auto own = static_cast<std::int32_t>(c.sum.size());
      const double size = 0.02 * std::pow(unit(random), 3), up = unit(random) < away ? -1 : 1;
      c.sum.push_back(node(size * tilt(random), size * tilt(random), size * up));
      join(h, own);
      if (k > 0) join(own - 1, own);
      if (k % 7 == 0 && planes > 1) join((h + 1) % planes, own);
    }
  return c;
}

MergeGraph rows_of(const Case& c) {
  MergeGraph g;
  g.sum.resize(c.sum.size());
  std::vector<std::vector<std::pair<std::int32_t, double>>> rows(c.sum.size());
  for (const auto& [pair, border] : c.border) {
    rows[pair.first].emplace_back(pair.second, border);
    rows[pair.second].emplace_back(pair.first, border);
  }
  g.first.push_back(0);
  for (const auto& row : rows) {
    for (const auto& [v, border] : row) {
      g.neighbour.push_back(v);
      g.border.push_back(border);
    }
    g.first.push_back(static_cast<std::int32_t>(g.neighbour.size()));
  }
  return g;
}

double length(const RegionSum& s) { return std::sqrt(s.x * s.x + s.y * s.y + s.z * s.z); }

double price(const RegionSum& a, const RegionSum& b, double border) {
  RegionSum both = a;
  both.add(b);
  const double lengths = length(a) + length(b);
  return lengths - length(both) + 1e-12 * lengths - border;
}

std::vector<std::int32_t> merged_slowly(const Case& c, std::size_t target) {
  std::vector<RegionSum> sum = c.sum;
  Borders border = c.border;
  std::vector<std::int32_t> into(sum.size());
  for (std::size_t u = 0; u < into.size(); ++u) into[u] = static_cast<std::int32_t>(u);
  for (std::size_t left = sum.size(); left > target; --left) {
    auto best = border.begin();
    double least = std::numeric_limits<double>::infinity();
    for (auto at = border.begin(); at != border.end(); ++at) {
      const double p = price(sum[at->first.first], sum[at->first.second], at->second);
      if (p >= least) continue;
      least = p;
      best = at;
    }
    const auto [u, v] = best->first;
    sum[u].add(sum[v]);
    for (std::int32_t& each : into)
      if (each == v) each = u;
    Borders next;
    for (const auto& [pair, b] : border) {
      const std::int32_t x = pair.first == v ? u : pair.first, y = pair.second == v ? u : pair.second;
      if (x != y) next[pair_of(x, y)] += b;
    }
    border = std::move(next);
  }
  std::vector<std::int32_t> number(sum.size(), -1), result;
  std::int32_t count = 0;
  for (const std::int32_t u : into) {
    if (number[u] < 0) number[u] = count++;
    result.push_back(number[u]);
  }
  return result;
}

struct Kind {
  std::int32_t planes, around;
  double away, length;
};

class Hubs : public testing::TestWithParam<Kind> {};

TEST_P(Hubs, MergeAsInASearchOfAllPairs) {
  const auto [planes, around, away, length] = GetParam();
  const std::vector<std::int32_t> need{1};
  for (std::uint32_t seed = 0; seed < 2; ++seed) {
    const Case c = houses(planes, around, away, length, seed);
    for (const std::int32_t target : {static_cast<std::int32_t>(c.sum.size()) / 2, 40, 2})
      EXPECT_EQ(merge_greedily(rows_of(c), c.sum, need, target, job()), merged_slowly(c, target))
          << seed << " " << target;
  }
}

TEST(Greedy, PollsWhileItMerges) {
  const Case c = houses(1, 5000, 0.0, 0.0, 1);
  Counting counting;
  (void)merge_greedily(rows_of(c), c.sum, std::vector<std::int32_t>{1}, 2, counting.job);
  EXPECT_GE(counting.polls, 4);
}

INSTANTIATE_TEST_SUITE_P(Greedy, Hubs,
                         testing::Values(Kind{1, 700, 0.0, 0.0}, Kind{1, 700, 0.0, 1e-4}, Kind{1, 500, 0.3, 1e-5},
                                         Kind{3, 350, 0.05, 0.0}, Kind{3, 350, 0.05, 1e-5}));

}  // namespace
}  // namespace isimp
