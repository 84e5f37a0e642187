// Turns faces so that neighbours agree.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>
#include <utility>

#include "surface/soup.h"

namespace isimp::detail {
namespace {

/// Sets of faces connected through consistently oriented pairs.
struct Patches {
  std::vector<std::int32_t> of_face;
  std::vector<double> area;
};

Patches find_patches(const Soup& soup, Job& job) {
  Patches patches;
  patches.of_face.assign(soup.named.size(), kNone);
  std::vector<std::int32_t> stack;
  std::size_t visited = 0;
  for (std::size_t start = 0; start < soup.named.size(); ++start) {
    if (patches.of_face[start] != kNone) continue;
    const auto id = static_cast<std::int32_t>(patches.area.size());
    double area = 0;
    patches.of_face[start] = id;
    stack.push_back(static_cast<std::int32_t>(start));
    while (!stack.empty()) {
      if (visited++ % kPollEvery == 0) job.poll();
      const std::int32_t f = stack.back();
      stack.pop_back();
      const auto& [a, b, c] = soup.named[f];
      area += (soup.vertices[b] - soup.vertices[a]).cross(soup.vertices[c] - soup.vertices[a]).norm() / 2;
      for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
        const std::int32_t other = soup.opposite[h];
        if (other == kNone || patches.of_face[other / 3] != kNone || soup.from(h) == soup.from(other)) continue;
        patches.of_face[other / 3] = id;
        stack.push_back(other / 3);
      }
    }
    patches.area.push_back(area);
  }
  return patches;
}

/// Sets of patches, each with a side: 1 if its orientation is opposite to that of the set's root.
class TwoSidedSets {
 public:
  explicit TwoSidedSets(std::size_t n) : parent_(n), side_(n, 0) { std::iota(parent_.begin(), parent_.end(), 0); }

  /// The root, and the side of `p` against it.
  std::pair<std::int32_t, char> find(std::int32_t p) {
    std::int32_t root = p;
    char side = 0;
    for (; parent_[root] != root; root = parent_[root]) side = static_cast<char>(side ^ side_[root]);
    for (char s = side; p != root;) {  // shorten the path
      const std::int32_t up = std::exchange(parent_[p], root);
      s = static_cast<char>(s ^ std::exchange(side_[p], s));
      p = up;
    }
    return {root, side};
  }
  /// Puts p and q on different sides of one set; false if they are on one side already.
  bool oppose(std::int32_t p, std::int32_t q) {
    const auto [root_p, side_p] = find(p);
    const auto [root_q, side_q] = find(q);
    if (root_p == root_q) return side_p != side_q;
    const auto [low, high] = std::minmax(root_p, root_q);
    parent_[high] = low;
    side_[high] = static_cast<char>(1 ^ side_p ^ side_q);
    return true;
  }

 private:
  std::vector<std::int32_t> parent_;
  std::vector<char> side_;
};

/// The seam between two patches. An edge made by welding is a seam of its own.
struct Seam {
  std::int32_t p, q;
  bool welded;
  double length;

  [[nodiscard]] auto key() const { return std::tuple(p, q, welded); }
};

/// Whether welding joined the faces of an edge.
bool is_welded(const Soup& soup, std::int32_t h) {
  const auto ends = [&](std::int32_t g) {
    const Triangle& t = soup.named[g / 3];
    return std::minmax({t[g % 3], t[(g + 1) % 3]});
  };
  return !soup.welded.empty() && ends(h) != ends(soup.opposite[h]);
}

std::vector<Seam> find_seams(const Soup& soup, const Patches& patches, const std::vector<std::int32_t>& same_way) {
  std::vector<Seam> seams;
  for (const std::int32_t h : same_way) {
    const auto [p, q] = std::minmax(patches.of_face[h / 3], patches.of_face[soup.opposite[h] / 3]);
    if (p != q)
      seams.push_back({p, q, is_welded(soup, h), (soup.vertices[soup.to(h)] - soup.vertices[soup.from(h)]).norm()});
  }
  std::stable_sort(seams.begin(), seams.end(), [](const Seam& a, const Seam& b) { return a.key() < b.key(); });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < seams.size(); ++i) {
    if (kept > 0 && seams[kept - 1].key() == seams[i].key()) {
      seams[kept - 1].length += seams[i].length;
    } else {
      seams[kept++] = seams[i];
    }
  }
  seams.resize(kept);
  return seams;
}

}  // namespace

/// The longest seams decide first, so that a surface with one side (a Moebius strip) is cut along a short seam; best
/// along one closed by welding alone, which then stays as in the caller's arrays.
std::vector<char> orient(Soup& soup, const std::vector<std::int32_t>& same_way, Job& job) {
  if (same_way.empty()) return {};
  const Patches patches = find_patches(soup, job);
  std::vector<Seam> seams = find_seams(soup, patches, same_way);
  std::stable_sort(seams.begin(), seams.end(), [](const Seam& a, const Seam& b) {
    return std::pair(a.welded, -a.length) < std::pair(b.welded, -b.length);
  });
  TwoSidedSets sets(patches.area.size());
  for (const Seam& seam : seams) sets.oppose(seam.p, seam.q);

  for (const std::int32_t h : same_way) {
    const std::int32_t other = soup.opposite[h];
    if (sets.oppose(patches.of_face[h / 3], patches.of_face[other / 3])) continue;
    if (!is_welded(soup, h)) soup.count_face(RepairKind::cut_edges, h / 3);
    soup.opposite[h] = soup.opposite[other] = kNone;
    soup.contested.insert(soup.contested.end(), {h, other});
  }

  std::vector<std::array<double, 2>> area(patches.area.size(), {0, 0});  // area of each side, at the root
  for (std::size_t p = 0; p < patches.area.size(); ++p) {
    const auto [root, side] = sets.find(static_cast<std::int32_t>(p));
    area[root][side] += patches.area[p];
  }
  std::vector<char> reversed(soup.named.size(), 0);
  for (std::size_t f = 0; f < reversed.size(); ++f) {
    const auto [root, side] = sets.find(patches.of_face[f]);
    reversed[f] = side == (area[root][1] <= area[root][0] ? 1 : 0);
    if (reversed[f]) soup.count_face(RepairKind::reversed_faces, static_cast<std::int32_t>(f));
  }
  return reversed;
}

void reverse_faces(Soup& soup, const std::vector<char>& marked) {
  if (marked.empty()) return;
  const auto moved = [&](std::int32_t h) {
    return h != kNone && marked[h / 3] ? 3 * (h / 3) + 2 - h % 3 : h;  // the half-edge between the same corners
  };
  for (std::size_t f = 0; f < marked.size(); ++f) {
    if (!marked[f]) continue;
    std::swap(soup.named[f][1], soup.named[f][2]);
    if (!soup.welded.empty()) std::swap(soup.welded[f][1], soup.welded[f][2]);
    std::swap(soup.opposite[3 * f], soup.opposite[3 * f + 2]);
  }
  for (std::int32_t& h : soup.opposite) h = moved(h);
  for (std::int32_t& h : soup.contested) h = moved(h);
}

}  // namespace isimp::detail
