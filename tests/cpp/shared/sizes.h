#pragma once

namespace isimp::checks {

/// The size of a test's input: sanitizers make a test ten times as slow.
constexpr int size([[maybe_unused]] int full, [[maybe_unused]] int sanitized) {
#ifdef ISIMP_SANITIZE
  return sanitized;
#else
  return full;
#endif
}

}  // namespace isimp::checks
