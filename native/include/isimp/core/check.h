#pragma once

#include <string>

#include "isimp/core/errors.h"

namespace isimp {

/// A statement about the engine's own state does not hold: a mistake in the engine, never in the caller's input.
class BrokenInvariant : public Error {
 public:
  using Error::Error;
};

namespace detail {

/// \throws BrokenInvariant  always; the message names the statement and its place in the source
[[noreturn]] void fail_assertion(const char* what, const char* condition, const char* file, int line);

}  // namespace detail
}  // namespace isimp

/// States an invariant that holds for every input: ISIMP_ASSERT(chart.face != kNone, "a live chart has a face").
///
/// Builds with the CMake option ISIMP_ASSERTIONS check it and throw BrokenInvariant where it does not hold, so that a
/// test fails with the place instead of continuing with damaged state. Other builds compile the condition, so that it
/// stays valid, and never evaluate it. Bad input is refused with InvalidInput, not asserted.
#ifdef ISIMP_ASSERTIONS
#define ISIMP_ASSERT(condition, what) \
  static_cast<void>((condition) ? 0 : (::isimp::detail::fail_assertion(what, #condition, __FILE__, __LINE__), 0))
#else
#define ISIMP_ASSERT(condition, what) static_cast<void>(true || (condition))
#endif
