#include "isimp/core/thread_count.h"

#include <future>
#include <new>
#include <system_error>
#include <vector>

namespace isimp {
namespace {

/// The number of threads, out of `wanted` and including the caller's, that live at once.
std::int32_t try_threads(std::int32_t wanted) {
  std::promise<void> end;
  const std::shared_future<void> ended = end.get_future().share();
  std::vector<std::jthread> threads;
  try {
    threads.reserve(static_cast<std::size_t>(wanted));
    while (static_cast<std::int32_t>(threads.size()) + 1 < wanted) threads.emplace_back([ended] { ended.wait(); });
  } catch (const std::system_error&) {  // the system starts no more
  } catch (const std::bad_alloc&) {
  }
  end.set_value();
  return static_cast<std::int32_t>(threads.size()) + 1;
}

}  // namespace

std::int32_t startable_threads(std::int32_t asked) {
  thread_local std::int32_t tried = 1, found = 1;
  const std::int32_t wanted = thread_count(asked);
  if (wanted > tried) {
    tried = wanted;
    found = try_threads(wanted);
    if (found < wanted) found = std::max(1, found / 2);  // the library needs memory of its own
  }
  return std::min(wanted, found);
}

}  // namespace isimp
