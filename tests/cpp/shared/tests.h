#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "isimp/core/errors.h"
#include "isimp/core/job.h"
#include "shapes.h"
#include "sizes.h"

/// What most tests include.
namespace isimp {

/// For calls that no test cancels or watches.
inline Job& job() {
  static Job shared;
  return shared;
}

/// A job that counts its polls, and is cancelled at the poll `stop` if that is above 0.
struct Counting {
  explicit Counting(std::int64_t stop = 0) {
    job.at_poll = [this, stop] {
      if (++polls == stop) job.cancel();
    };
  }
  Job job;
  std::atomic<std::int64_t> polls{0};
};

/// The message of the error that `call` throws.
template <class Error = InvalidInput, class Call>
std::string message_of(Call call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

}  // namespace isimp
