// Undoing changes of a state of meshing restores it, bit by bit, after any changes.
#include <bit>
#include <cstring>

#include "complex/state.h"
#include "complex/transaction.h"
#include "labelled.h"
#include "tests.h"

namespace isimp::meshing {
namespace {

/// FNV-1a of values, one after the other.
class Digest {
 public:
  void add(std::uint64_t value) {
    for (int byte = 0; byte < 8; ++byte) sum_ = (sum_ ^ ((value >> (8 * byte)) & 0xff)) * 0x100000001b3;
  }
  void add(std::int32_t value) { add(std::uint64_t{static_cast<std::uint32_t>(value)}); }
  void add(std::uint8_t value) { add(std::uint64_t{value}); }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void add(const Chart& p) {
    add(p.face);
    add(p.region);
    add(static_cast<std::uint8_t>(p.cause));
  }
  void add(const Vec3& p) {
    for (int k = 0; k < 3; ++k) add(p[k]);
  }
  void add(const Plane& p) {
    add(p.normal);
    add(p.centre);
    for (int k = 0; k < 9; ++k) add(p.spread(k / 3, k % 3));
    add(p.area);
    add(p.projected);
    add(std::uint8_t{static_cast<std::uint8_t>(p.held + 2 * p.snapped)});
  }
  template <class T>
  void add(const std::vector<T>& values) {
    add(std::uint64_t{values.size()});
    for (const T& value : values) add(value);
  }
  template <std::size_t n>
  void add(const std::array<std::int32_t, n>& values) {
    for (const std::int32_t value : values) add(value);
  }
  /// The private ones of Polygons: whole numbers without gaps.
  template <class T>
  void add(const T& value) {
    static_assert(std::has_unique_object_representations_v<T> && sizeof(T) % sizeof(std::int32_t) == 0);
    std::array<std::int32_t, sizeof(T) / sizeof(std::int32_t)> words;
    std::memcpy(words.data(), &value, sizeof(T));
    add(words);
  }
  [[nodiscard]] std::uint64_t sum() const { return sum_; }

 private:
  std::uint64_t sum_ = 0xcbf29ce484222325;
};

/// One for each array.
std::vector<std::uint64_t> digests(const State& state) {
  std::vector<std::uint64_t> all;
  state.for_each_array([&](const auto& array) {
    Digest d;
    for (const auto& value : array) d.add(value);
    d.add(std::uint64_t{array.size()});
    all.push_back(d.sum());
  });
  return all;
}

/// The number of places of arrays that a transaction has saved, and the number of all places.
std::pair<std::size_t, std::size_t> written(const State& state) {
  std::pair<std::size_t, std::size_t> places{0, 0};
  state.for_each_array([&](const auto& array) {
    places.first += array.written().size();
    places.second += array.size();
  });
  return places;
}

/// Applies all possible changes to a state, by chance.
class Hands {
 public:
  Hands(State& state, unsigned seed) : s_(state), random_(seed) {}

  /// \param may_keep  whether corners may keep their places, as within a transaction
  void act(bool may_keep = false) {
    const std::int32_t l = chart();
    std::vector<std::int32_t> changed;
    switch (below(7)) {
      case 0:
        s_.split(l, job());
        break;
      case 1:
      case 2:
        unite(l);
        break;
      case 3:
        if (s_.labels.faces_of(l).size() < 12 && s_.shatter(l)) changed.push_back(l);
        break;
      case 4:
        toggle_corner(s_.mesh.from(one_of(s_.complex.loop(l))));
        break;
      case 5:
        add_diagonal(l);
        changed.push_back(l);
        break;
      default: {
        const std::int32_t c = one_of(s_.polygons.of(s_.polygons.first_of(l)));
        s_.move(c, s_.corners.position[c] + Vec3(0.01, 0.02, -0.01));
        return;
      }
    }
    if (may_keep && below(2) == 0)
      s_.update_in_place(std::move(changed));
    else
      s_.update(std::move(changed));
  }

  std::int32_t below(std::int32_t n) { return static_cast<std::int32_t>(random_() % static_cast<unsigned>(n)); }

 private:
  std::int32_t chart() {
    while (true)
      if (const std::int32_t l = below(s_.labels.chart_count()); s_.labels.charts[l].face != kNone) return l;
  }
  std::int32_t one_of(std::span<const std::int32_t> some) {
    return some[below(static_cast<std::int32_t>(some.size()))];
  }

  void unite(std::int32_t kept) {
    const std::vector<std::int32_t> beside = s_.neighbours(kept);
    if (beside.empty()) return;
    const std::int32_t gone = one_of(beside);
    const std::vector<std::int32_t> loop = s_.loop_together(kept, gone);
    if (!loop.empty() && loop.size() > 3) s_.unite(kept, gone, loop);
  }
  void toggle_corner(std::int32_t v) {
    if (s_.complex.is_corner(v))
      s_.drop_corner(v);
    else
      s_.add_corner(v);
  }
  void add_diagonal(std::int32_t l) {
    const auto loop = s_.polygons.of(s_.polygons.first_of(l));
    if (loop.size() < 4) return;
    std::vector<std::array<std::int32_t, 2>> all = s_.diagonals[l];
    all.push_back({s_.corners.vertex[loop[0]], s_.corners.vertex[loop[2]]});
    s_.set_diagonals(l, all);
  }

  State& s_;
  std::mt19937 random_;
};

struct Case {
  std::string name;
  Mesh mesh;
  Partition part;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  const auto add = [&](const std::string& name, const shapes::Arrays& arrays, int regions) {
    const Mesh mesh = shapes::mesh(arrays);
    all.push_back({name, mesh, regions > 0 ? labelled::voronoi(mesh, regions, 3) : labelled::planes(mesh)});
  };
  add("sphere", shapes::noisy(shapes::sphere(4), 0.01, 1), 40);
  add("torus", shapes::noisy(shapes::torus(40, 20), 0.005, 2), 12);
  add("square", shapes::noisy(shapes::plane(16), 0.01, 3), 10);
  add("plate", shapes::perforated(12, 12, 0.1, [](int x, int y) { return x % 3 == 1 && y % 3 == 1; }), 0);
  return all;
}

/// Calls fn(state, equal state) for each case.
template <class Function>
void for_each_pair(Function fn) {
  const MeshingOptions options{.threads = 1};
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    State one(c.mesh, c.part, options, job()), other(c.mesh, c.part, options, job());
    one.update({});
    other.update({});
    fn(one, other);
  }
}

class Transactions : public testing::TestWithParam<unsigned> {};

/// After each that is rolled back, the state is as before and changes as one that never had it; so after one that is
/// committed.
TEST_P(Transactions, LeaveNothingBehindUnlessTheyAreCommitted) {
  for_each_pair([](State& tried, State& plain) {
    Hands any(tried, GetParam() + 100), one(tried, GetParam()), other(plain, GetParam());
    for (int round = 0; round < 6; ++round) {
      const std::vector<std::uint64_t> before = digests(tried);
      {
        Transaction transaction(tried);  // rolls back as it is not committed
        for (int i = 0; i < 12; ++i) any.act(true);
        EXPECT_NE(digests(tried), before);
        if (round % 2 == 0) transaction.rollback();
      }
      EXPECT_EQ(digests(tried), before);
      Transaction transaction(tried);
      for (int i = 0; i < 3; ++i) one.act();
      transaction.commit();
      for (int i = 0; i < 3; ++i) other.act();
      ASSERT_EQ(digests(tried), digests(plain)) << "round " << round;
    }
  });
}

TEST(Transaction, UndoesArraysBesideAState) {
  for_each_pair([](State& state, State& same) {
    Logged<int> beside(3, 1);
    const auto change = [&] {
      state.move(0, state.corners.position[0] + Vec3(1, 2, 3));
      beside.set(1, 5);
      beside.push_back(7);
    };
    {
      Transaction transaction(state, beside);
      change();
    }
    EXPECT_EQ(digests(state), digests(same));
    EXPECT_EQ(beside, std::vector<int>({1, 1, 1}));
    {
      Transaction transaction(state, beside);
      change();
      transaction.commit();
    }
    EXPECT_NE(digests(state), digests(same));
    EXPECT_EQ(beside, std::vector<int>({1, 5, 1, 7}));
  });
}

INSTANTIATE_TEST_SUITE_P(Seeds, Transactions, testing::Range(1U, 9U));

TEST(Transaction, KeepsOnlyWhatAUnionChanges) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(6), 0.005, 1));
  const Partition part = labelled::voronoi(mesh, 400, 3);
  const MeshingOptions options{.threads = 1};
  State state(mesh, part, options, job());
  state.update({});
  Transaction transaction(state);
  const std::size_t faces = state.labels.faces_of(1).size();
  const std::int32_t kept = state.neighbours(1).front();
  state.unite(kept, 1, state.loop_together(kept, 1));
  EXPECT_EQ(state.labels.label.written().size(), faces);
  EXPECT_EQ(state.labels.charts.written(), std::vector<std::int32_t>{1});
  state.update({});
  const auto [places, all] = written(state);
  EXPECT_GT(places, faces);
  EXPECT_LT(places, all / 100);
}

}  // namespace
}  // namespace isimp::meshing
