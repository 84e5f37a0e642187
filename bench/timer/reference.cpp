// REF: variational shape approximation written down plainly. The engine's own methods are measured against it. It has none
// of the engine's optimisations, on purpose: the caller's face order, double precision, one priority queue.
// Source: Cohen-Steiner, Alliez, Desbrun 2004, section 3.
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <limits>
#include <queue>
#include <vector>

namespace {

using Vec = std::array<double, 3>;

double squared_distance(const Vec& a, const Vec& b) {
  return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]);
}

struct Entry {
  double error;
  int face, region;
  bool operator<(const Entry& o) const { return error > o.error; }  // std::priority_queue returns the greatest
};

struct Surface {
  int faces;
  const Vec* normal;                     // unit
  const double* area;                    // as a share of the whole surface's area
  const std::array<int, 3>* neighbours;  // -1 where none
};

void flood(const Surface& surface, const std::vector<int>& seed, const std::vector<Vec>& proxy, int* label) {
  std::fill(label, label + surface.faces, -1);
  std::priority_queue<Entry> queue;
  const auto offer_neighbours = [&](int face, int region) {
    for (const int other : surface.neighbours[face])
      if (other >= 0 && label[other] < 0)
        queue.push({squared_distance(surface.normal[other], proxy[region]), other, region});
  };
  const int regions = static_cast<int>(seed.size());
  for (int r = 0; r < regions; ++r) label[seed[r]] = r;
  for (int r = 0; r < regions; ++r) offer_neighbours(seed[r], r);
  while (!queue.empty()) {
    const Entry least = queue.top();
    queue.pop();
    if (label[least.face] >= 0) continue;
    label[least.face] = least.region;
    offer_neighbours(least.face, least.region);
  }
}

// Fits proxies and chooses seeds. With S the sum of area * normal over a region of area A, its error is 2 (A - |S|).
double fit(const Surface& surface, const int* label, std::vector<int>& seed, std::vector<Vec>& proxy) {
  std::vector<std::array<double, 4>> sum(seed.size(), {0, 0, 0, 0});  // the last one: the area
  for (int f = 0; f < surface.faces; ++f) {
    if (label[f] < 0) continue;
    for (int k = 0; k < 3; ++k) sum[label[f]][k] += surface.area[f] * surface.normal[f][k];
    sum[label[f]][3] += surface.area[f];
  }
  double error = 0.0;
  for (std::size_t r = 0; r < seed.size(); ++r) {
    const double length = std::hypot(sum[r][0], sum[r][1], sum[r][2]);
    error += 2 * (sum[r][3] - length);
    if (length > 0) proxy[r] = {sum[r][0] / length, sum[r][1] / length, sum[r][2] / length};
  }
  std::vector<double> least(seed.size(), std::numeric_limits<double>::infinity());
  for (int f = 0; f < surface.faces; ++f) {
    if (label[f] < 0) continue;
    const double difference = squared_distance(surface.normal[f], proxy[label[f]]);
    if (difference >= least[label[f]]) continue;
    least[label[f]] = difference;
    seed[label[f]] = f;
  }
  return error;
}

}  // namespace

// Floods from distinct seeds, fits, and floods again, for a fixed number of rounds. The priority is the squared difference
// of the normals alone, without the face's area; so is the choice of the new seeds. Components without a seed stay without
// a region. errors, milliseconds: of each round, of the processor.
extern "C" void reference(int faces, const double* normals, const double* areas, const int* neighbours, int proxies,
                          const int* seeds, int rounds, int* label, double* errors, double* milliseconds) {
  const Surface surface{faces, reinterpret_cast<const Vec*>(normals), areas,
                        reinterpret_cast<const std::array<int, 3>*>(neighbours)};
  std::vector<int> seed(seeds, seeds + proxies);
  std::vector<Vec> proxy;
  for (const int face : seed) proxy.push_back(surface.normal[face]);
  for (int round = 0; round < rounds; ++round) {
    const std::clock_t started = std::clock();
    flood(surface, seed, proxy, label);
    errors[round] = fit(surface, label, seed, proxy);
    milliseconds[round] = 1e3 * static_cast<double>(std::clock() - started) / CLOCKS_PER_SEC;
  }
}
