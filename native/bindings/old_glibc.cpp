// Symbols of newer C libraries than the module runs with, which GCC's C++ library, put into the module by
// ISIMP_OLD_GLIBC, requires.
#include <sys/random.h>

#include <cstdlib>

extern "C" {

// Since glibc 2.32: whether a program has one thread, so that counts of owners need no atomic operations. Here: perhaps
// not.
__attribute__((visibility("hidden"))) extern char __libc_single_threaded;  // NOLINT(bugprone-reserved-identifier)
char __libc_single_threaded = 0;                                           // NOLINT(bugprone-reserved-identifier)

// Since glibc 2.36: called by std::random_device.
__attribute__((visibility("hidden"))) unsigned arc4random();
unsigned arc4random() {
  unsigned value = 0;
  if (getentropy(&value, sizeof value) != 0) std::abort();
  return value;
}
}
