#pragma once

/// Marks a function that is called, not inlined: in a large function, the hot loop would run out of registers.
#if defined(_MSC_VER) && !defined(__clang__)
#define ISIMP_NOINLINE __declspec(noinline)
#else
#define ISIMP_NOINLINE [[gnu::noinline]]
#endif
