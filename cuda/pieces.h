#pragma once

#include <limits>

#include "flooding.h"
#include "summing.h"

/// The pieces in which regions lie: faces of one label that hang together. Each piece is named by its first face, so
/// that no order of joining changes a name.
namespace isimp::parallel::ISIMP_DEVICE {

/// Makes every face a piece of its own.
struct Alone {
  std::int32_t* parent;  ///< (N)
  ISIMP_KERNEL void operator()(std::int64_t i) const { parent[i] = static_cast<std::int32_t>(i); }
};

/// Joins a face to its neighbours of the same label. The larger root always becomes a child of the smaller.
/// Source: the hooking of ECL-CC, Jaiganesh and Burtscher 2018.
struct Join {
  View view;
  std::int32_t* parent;  ///< (N)

  ISIMP_KERNEL void operator()(std::int64_t face) const {
    const auto i = static_cast<std::int32_t>(face);
    if (view.label[i] < 0) return;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t j = view.neighbour(i, k);
      if (j < i && view.label[j] == view.label[i]) join(i, j);
    }
  }
  ISIMP_KERNEL std::int32_t root(std::int32_t i) const {
    std::int32_t above = shared(parent[i]).load(kRelaxed);
    while (above != i) {
      const std::int32_t next = shared(parent[above]).load(kRelaxed);
      if (next != above) shared(parent[i]).store(next, kRelaxed);  // halves the path for later searches
      i = above;
      above = next;
    }
    return i;
  }
  ISIMP_KERNEL void join(std::int32_t i, std::int32_t j) const {
    for (;;) {
      i = root(i);
      j = root(j);
      if (i == j) return;
      if (i < j) {
        const std::int32_t other = i;
        i = j;
        j = other;
      }
      std::int32_t expected = i;
      if (shared(parent[i]).compare_exchange_strong(expected, j, kRelaxed)) return;
    }
  }
};

/// Hangs every face directly below the first of its piece, and adds up the pieces' areas there.
struct Flatten {
  Join join;
  const float* faces;
  double scale;
  std::int32_t* root;  ///< (N)
  Integer* area;       ///< (N) of the piece, at its first face

  ISIMP_KERNEL void operator()(std::int64_t i) const {
    root[i] = join.root(static_cast<std::int32_t>(i));
    if (join.view.label[i] >= 0) shared(area[root[i]]).fetch_add(llrint(faces[4 * i + 3] * scale), kRelaxed);
  }
};

struct LargestPiece {
  View view;
  const std::int32_t* root;
  const Integer* area;
  Integer* largest;  ///< (R)

  ISIMP_KERNEL void operator()(std::int64_t i) const {
    if (view.label[i] >= 0 && root[i] == i) shared(largest[view.label[i]]).fetch_max(area[i], kRelaxed);
  }
};

/// Selects, among equally large pieces, the one that begins first.
struct FirstOfLargest {
  LargestPiece find;
  std::int32_t* first;  ///< (R)

  ISIMP_KERNEL void operator()(std::int64_t i) const {
    const std::int32_t r = find.view.label[i];
    if (r >= 0 && find.root[i] == i && find.area[i] == find.largest[r])
      shared(first[r]).fetch_min(static_cast<std::int32_t>(i), kRelaxed);
  }
};

/// Frees a face that is not in its region's largest piece.
/// \return 1 for such a face
struct FreeOthers {
  View view;
  const std::int32_t* root;
  const std::int32_t* first;

  ISIMP_KERNEL std::int32_t operator()(std::int64_t i) const {
    if (view.label[i] < 0 || first[view.label[i]] == root[i]) return 0;
    view.label[i] = -1;
    return 1;
  }
};

}  // namespace isimp::parallel::ISIMP_DEVICE
