// The cases that are timed, by name.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "input.h"
#include "isimp/mesh/mesh.h"
#include "json.h"
#include "measure.h"
#include "reference.h"

namespace isimp::bench {

/// The result of one run of a case: usually one lap; edits give one for each face tried.
struct Sample {
  std::vector<Lap> laps;
  Json facts;  ///< figures of the result: error, counts
};

/// A timed case. Only the work between the stopwatches of `run` counts.
struct Case {
  std::string name;
  std::function<Sample(int round)> run;  ///< `round` counts from 1 and is also the seed of random numbers
  int inner = 1;                         ///< runs a round; short cases are run several times
};

struct Setup {
  std::string file;  ///< empty for a mesh that was made
  std::string scratch;
  Arrays arrays;
  std::shared_ptr<const Mesh> mesh;
  PlainSurface surface;
  std::int32_t proxies = 500, edits = 200, inner = 3;
};

/// All cases, in the order of a round.
std::vector<Case> all_cases(const std::shared_ptr<const Setup>& setup);

/// One pass from file (or arrays) to polygons: for each phase its time, its peak memory and the memory that it keeps.
Json whole_way(const std::string& input, std::int32_t loop, std::int32_t proxies, const std::string& scratch);

}  // namespace isimp::bench
