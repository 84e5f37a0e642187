#pragma once

#ifdef _MSC_VER
#include <intrin.h>
#endif

namespace isimp {

/// Prefetches the cache line of a place that is soon read. Changes no result.
inline void prefetch(const void* place) {
#if defined(_MSC_VER) && (defined(_M_X64) || defined(_M_IX86))
  _mm_prefetch(static_cast<const char*>(place), _MM_HINT_T0);
#elif defined(_MSC_VER) && defined(_M_ARM64)
  __prefetch(place);
#elif defined(__GNUC__)
  __builtin_prefetch(place);
#else
  (void)place;
#endif
}

/// As `prefetch`, for a place that is soon written.
inline void prefetch_to_write(const void* place) {
#if defined(__GNUC__) && !defined(_MSC_VER)
  __builtin_prefetch(place, 1);
#else
  prefetch(place);
#endif
}

}  // namespace isimp
