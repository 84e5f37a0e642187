// The search for polygons and for faces of the scan that meet finds exactly the pairs that a test of all pairs finds.
#include "isimp/mesh/clean.h"
#include "isimp/mesh/meet.h"
#include "judge/judge.h"
#include "tests.h"

namespace isimp::meshing {
namespace {

using Key = std::array<std::int32_t, 4>;

/// Triangles and bent quadrilaterals between points of a coarse lattice: many share corners or lie in one plane. Every
/// fourth chart has two polygons.
struct Made {
  std::vector<Vec3> position;
  std::vector<FacetSet> charts;

  explicit Made(unsigned seed) : random_(seed) {
    for (int i = 0; i < 60; ++i) position.push_back(Vec3(any(8), any(8), any(4)) * 0.37);
    for (std::int32_t l = 0; l < 40; ++l) {
      charts.emplace_back();
      for (std::int32_t part = 0; part < (l % 4 == 0 ? 2 : 1); ++part) add_polygon(l, part);
      charts.back().locate(position);
    }
  }

  [[nodiscard]] std::vector<bool> some(int of) {
    std::vector<bool> chosen(charts.size());
    for (std::size_t l = 0; l < chosen.size(); ++l) chosen[l] = any(of) == 0;
    return chosen;
  }

  [[nodiscard]] std::vector<Key> found(const std::vector<bool>& changed, const std::vector<bool>& known) const {
    std::vector<const FacetSet*> sets;
    Arounds arounds;
    for (const FacetSet& p : charts) {
      arounds.set(static_cast<std::int32_t>(sets.size()), p);
      sets.push_back(&p);
    }
    arounds.settle();
    std::vector<Key> keys;
    const Job job;
    for (const Hit& h : find_hits(sets, arounds, changed, known, Threads(2), job)) keys.push_back(h.key());
    return keys;
  }

  [[nodiscard]] std::vector<Key> expected(const std::vector<bool>& changed, const std::vector<bool>& known) const {
    std::vector<Key> keys;
    for (std::size_t a = 0; a < charts.size(); ++a)
      for (std::size_t b = a; b < charts.size(); ++b)
        if ((changed[a] || changed[b]) && !(known[a] && known[b])) add_pairs(charts[a], charts[b], keys);
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    return keys;
  }

 private:
  int any(int below) { return static_cast<int>(random_() % static_cast<unsigned>(below)); }

  void add_polygon(std::int32_t chart, std::int32_t part) {
    std::vector<std::int32_t> corners(position.size());
    std::iota(corners.begin(), corners.end(), 0);
    const Vec3 middle = position[any(60)];
    std::shuffle(corners.begin(), corners.end(), random_);
    std::stable_sort(corners.begin(), corners.begin() + 12, [&](std::int32_t c, std::int32_t d) {
      return (position[c] - middle).squaredNorm() < (position[d] - middle).squaredNorm();
    });
    const Facet like{{}, chart, part};
    auto& facets = charts.back().facets;
    facets.push_back(like);
    facets.back().corner = {corners[0], corners[1], corners[2]};
    if (any(2) == 0) return;
    facets.push_back(like);
    facets.back().corner = {corners[0], corners[2], corners[3]};
  }

  static void add_pairs(const FacetSet& a, const FacetSet& b, std::vector<Key>& keys) {
    for (std::size_t i = 0; i < a.facets.size(); ++i)
      for (std::size_t j = 0; j < b.facets.size(); ++j) {
        const Facet &f = a.facets[i], &g = b.facets[j];
        if (f.chart == g.chart && f.part >= g.part) continue;
        if (!has_area(a.solids[i]) || !has_area(b.solids[j])) continue;
        if (meet_elsewhere(f.corner, a.solids[i], g.corner, b.solids[j]))
          keys.push_back({f.chart, g.chart, f.part, g.part});
      }
  }

  std::mt19937 random_;
};

TEST(Intersections, ThoseOfPolygonsAreThoseOfAllPairs) {
  std::size_t met = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    Made made(seed);
    const std::vector<bool> all(made.charts.size(), true), none(made.charts.size(), false);
    EXPECT_EQ(made.found(all, none), made.expected(all, none)) << seed;
    const std::vector<bool> changed = made.some(3), known = made.some(2);
    EXPECT_EQ(made.found(changed, known), made.expected(changed, known)) << seed;
    met += made.found(all, none).size();
  }
  EXPECT_GT(met, 1000U);
}

TEST(Intersections, ThoseOfTheScanAreThoseOfAllPairs) {
  const auto stored = [](const Mesh& mesh, std::int32_t f) {
    isimp::Corners corners;
    for (int k = 0; k < 3; ++k) corners[k] = rounded_to_float(mesh.vertices()[mesh.triangles()[f][k]]);
    return corners;
  };
  std::array<int, 2> said{0, 0};
  for (unsigned seed = 0; seed < 60; ++seed) {
    // A sheet that is folded at random, so that faces share vertices, in two parts.
    std::mt19937 random(seed);
    constexpr std::int32_t kSide = 5;
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (std::int32_t y = 0; y <= kSide; ++y)
      for (std::int32_t x = 0; x <= kSide; ++x)
        vertices.emplace_back(x + 0.4 * (random() % 4), y + 0.4 * (random() % 4), 0.3 * (random() % 3));
    for (std::int32_t y = 0; y < kSide; ++y)
      for (std::int32_t x = 0; x < kSide; ++x) {
        const std::int32_t a = y * (kSide + 1) + x, b = a + 1, c = a + kSide + 1, d = c + 1;
        triangles.push_back({a, b, d});
        triangles.push_back({a, d, c});
      }
    const Mesh mesh(vertices, triangles, job());
    std::array<std::vector<std::int32_t>, 2> half;
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) half[f / 10 % 2].push_back(f);
    bool meet = false;
    for (const std::int32_t f : half[0])
      for (const std::int32_t g : half[1])
        meet = meet || (has_area(stored(mesh, f)) && has_area(stored(mesh, g)) &&
                        meet_elsewhere(mesh.triangles()[f], stored(mesh, f), mesh.triangles()[g], stored(mesh, g)));
    ++said[meet];
    EXPECT_EQ(scan_intersects(mesh, ScanPart(mesh, half[0]), ScanPart(mesh, half[1])), meet) << seed;
  }
  EXPECT_GT(said[0], 5);
  EXPECT_GT(said[1], 5);
}

}  // namespace
}  // namespace isimp::meshing
