#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "flooding.h"

/// Naive flooding: every face compares the regions nearest to it.
namespace isimp::parallel::ISIMP_DEVICE {

/// The regions' centres in a grid of cells over the unit cube.
struct Grid {
  const std::int32_t* start;   ///< (cells + 1) first entry of each cell in `region`
  const std::int32_t* region;  ///< (R) cell by cell
  std::int32_t side;           ///< cells along an axis
};

/// The nearest regions of one face among the visited ones, by distance, then by region.
struct Candidates {
  std::int32_t wanted, found;
  float distance[32];
  std::int32_t region[32];

  ISIMP_KERNEL void offer(float d, std::int32_t r) {
    if (found == wanted && !before(d, r, found - 1)) return;
    std::int32_t at = found < wanted ? found++ : found - 1;
    for (; at > 0 && before(d, r, at - 1); --at) {
      distance[at] = distance[at - 1];
      region[at] = region[at - 1];
    }
    distance[at] = d;
    region[at] = r;
  }
  ISIMP_KERNEL bool before(float d, std::int32_t r, std::int32_t at) const {
    return d < distance[at] || (d == distance[at] && r < region[at]);
  }
};

struct ChooseNear {
  View view;
  const float* place;                ///< (3 N) the faces' centres
  const Normal* centre;              ///< (R) the regions'
  const std::int32_t* component;     ///< (N); null if there is one component
  const std::int32_t* in_component;  ///< (C) number of regions of each component
  std::int32_t nearest, regions;
  Grid grid;  ///< null for brute force

  ISIMP_KERNEL void operator()(std::int64_t face) const {
    const auto i = static_cast<std::int32_t>(face);
    Candidates near;
    near.found = 0;
    near.region[0] = 0;  // at least one is found, which compilers can't see
    near.wanted = component == nullptr ? regions : in_component[component[i]];
    if (near.wanted > nearest) near.wanted = nearest;
    if (near.wanted == 0) return;  // its component was left out
    if (grid.start == nullptr) {
      for (std::int32_t r = 0; r < regions; ++r) offer(near, i, r);
    } else {
      search(near, i);
    }
    std::int32_t best = near.region[0];
    float least = view.error(i, best);
    for (std::int32_t k = 1; k < near.found; ++k) {
      const float e = view.error(i, near.region[k]);
      if (e < least) {
        least = e;
        best = near.region[k];
      }
    }
    if (view.label[i] < 0) view.label[i] = best;  // seeds have theirs
  }

 private:
  ISIMP_KERNEL void offer(Candidates& near, std::int32_t i, std::int32_t r) const {
    if (component != nullptr && component[i] != component[view.seed[r]]) return;
    const float* p = place + 3 * static_cast<std::int64_t>(i);
    const float x = p[0] - centre[r].x, y = p[1] - centre[r].y, z = p[2] - centre[r].z;
    near.offer(x * x + y * y + z * z, r);
  }

  /// Visits cells in growing cubes around the face's, until all other cells are farther than the wanted regions.
  ISIMP_KERNEL void search(Candidates& near, std::int32_t i) const {
    const float* p = place + 3 * static_cast<std::int64_t>(i);
    std::int32_t cell[3];
    for (int k = 0; k < 3; ++k) cell[k] = cell_of(p[k], grid.side);
    for (std::int32_t reach = 0; reach < grid.side; ++reach) {
      const float seen = static_cast<float>(reach) - 1.001F;  // in cells, with room for rounding
      const auto side = static_cast<float>(grid.side);
      if (near.found == near.wanted && seen > 0 && near.distance[near.found - 1] * side * side < seen * seen) return;
      shell(near, i, cell, reach);
    }
  }
  ISIMP_KERNEL void shell(Candidates& near, std::int32_t i, const std::int32_t (&c)[3], std::int32_t reach) const {
    for (std::int32_t z = c[2] - reach; z <= c[2] + reach; ++z) {
      if (z < 0 || z >= grid.side) continue;
      const bool lid = z == c[2] - reach || z == c[2] + reach;
      for (std::int32_t y = c[1] - reach; y <= c[1] + reach; ++y) {
        if (y < 0 || y >= grid.side) continue;
        const std::int32_t step = lid || y == c[1] - reach || y == c[1] + reach || reach == 0 ? 1 : 2 * reach;
        for (std::int32_t x = c[0] - reach; x <= c[0] + reach; x += step) {
          if (x < 0 || x >= grid.side) continue;
          const std::int32_t at = (z * grid.side + y) * grid.side + x;
          for (std::int32_t k = grid.start[at]; k < grid.start[at + 1]; ++k) offer(near, i, grid.region[k]);
        }
      }
    }
  }

 public:
  /// As above on the host, where the grid is made.
  ISIMP_KERNEL static std::int32_t cell_of(float x, std::int32_t side) {
    const float cell = x * static_cast<float>(side);
    if (!(cell > 0)) return 0;  // also if not a number, whose conversion is undefined
    return cell < static_cast<float>(side) ? static_cast<std::int32_t>(cell) : side - 1;
  }
};

/// The grid of regions on the host: about two regions in each cell that the surface passes through.
struct HostGrid {
  std::int32_t side;
  std::vector<std::int32_t> start, region;

  explicit HostGrid(const std::vector<float>& centre) {
    const auto regions = static_cast<std::int32_t>(centre.size() / 3);
    side = std::clamp(static_cast<std::int32_t>(std::sqrt(static_cast<double>(regions)) / 2.5), 1, 64);
    std::vector<std::int32_t> cell(static_cast<std::size_t>(regions));
    start.assign(static_cast<std::size_t>(side) * side * side + 1, 0);
    for (std::int32_t r = 0; r < regions; ++r) {
      const auto of = [&](int k) { return ChooseNear::cell_of(centre[3 * r + k], side); };
      cell[r] = (of(2) * side + of(1)) * side + of(0);
      ++start[cell[r] + 1];
    }
    for (std::size_t c = 1; c < start.size(); ++c) start[c] += start[c - 1];
    region.resize(cell.size());
    std::vector<std::int32_t> fill(start.begin(), start.end() - 1);
    for (std::int32_t r = 0; r < regions; ++r) region[fill[cell[r]]++] = r;
  }
};

}  // namespace isimp::parallel::ISIMP_DEVICE
