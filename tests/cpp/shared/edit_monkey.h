#pragma once

#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"

/// Edits of every kind at many faces of a partition. Each result is checked against the headers of interact/.
namespace isimp::monkey {

/// Counts of edits, and their faults.
struct Tally {
  struct Count {
    std::int64_t done = 0, refused = 0;
  };
  std::map<std::string, Count> edits;  ///< by name of the edit
  std::int64_t partitions = 0, polygonized = 0;
  std::int64_t small_pieces = 0;      ///< regions of fewer than four faces that were met
  std::vector<std::string> findings;  ///< each with the edit, the face and the seed
  [[nodiscard]] std::int64_t actions() const;
};

struct Settings {
  std::uint32_t seed = 1;
  int random_regions = 50;  ///< whose faces are edited
  int faces_of_region = 4;  ///< number of faces drawn from each region
  int random_faces = 200;
  int edits_at_face = 3;       ///< drawn of all edits; at faces of small regions all are tried
  int chains = 2, chain = 30;  ///< edits one after another
  bool polygonize = true;      ///< the first partition and the ends of chains
  double seconds = 1e9;        ///< after which nothing more is begun
};

/// Edits a partition, and the results in chains.
/// \param name  of the scan and of how it was split, for findings
void run(const Mesh& mesh, const Partition& partition, const std::string& name, const Settings& settings, Tally& tally);

/// Options of partitions that a scan is split with: by detail, number, bound, with adaptivity, weights,
/// barriers, cuts, locks and of some faces only.
/// \param details  (K) each is taken with adaptivity 0 and .25 and smooth 0 and .5
/// \param guided   whether constraints are tried too
void run_all(const Mesh& mesh, const std::string& name, const std::vector<double>& details, bool guided,
             const Settings& settings, Tally& tally);

/// A table of the counts and the findings, one a line.
std::string report(const Tally& tally);

}  // namespace isimp::monkey
