#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <thread>
#include <vector>

namespace isimp {

/// The one place where partitioning starts threads: loops cut into equal pieces, one a thread, none waiting busily.
///
/// What the pieces write must not depend on how many there are; whoever calls sees to that. Threads live for one loop:
/// starting one costs some 20 us, so short loops are left to the caller's thread.
class Threads {
 public:
  /// \param count  0: as many as the machine has
  explicit Threads(std::int32_t count)
      : count_(count > 0 ? count : std::max(1, static_cast<std::int32_t>(std::thread::hardware_concurrency()))) {}

  /// How many pieces `run` will cut n steps into. \param least  steps below which a piece is not worth a thread
  [[nodiscard]] std::int32_t pieces(std::int32_t n, std::int32_t least = 1 << 14) const {
    return std::clamp(n / least, 1, count_);
  }

  /// Calls body(piece, begin, end) for each of so many pieces of [0, n). The first exception is thrown on.
  template <class Body>
  void run(std::int32_t n, std::int32_t pieces, Body body) const {
    const auto edge = [&](std::int32_t piece) {
      return static_cast<std::int32_t>(static_cast<std::int64_t>(n) * piece / pieces);
    };
    std::vector<std::exception_ptr> failure(static_cast<std::size_t>(pieces));
    const auto guarded = [&](std::int32_t piece) {
      try {
        body(piece, edge(piece), edge(piece + 1));
      } catch (...) {
        failure[piece] = std::current_exception();
      }
    };
    {
      std::vector<std::jthread> others;
      for (std::int32_t piece = 1; piece < pieces; ++piece) others.emplace_back(guarded, piece);
      guarded(0);
    }
    for (const std::exception_ptr& e : failure)
      if (e) std::rethrow_exception(e);
  }
  template <class Body>
  void run(std::int32_t n, Body body) const {
    run(n, pieces(n), body);
  }

  /// For steps of unequal length: calls body(next) once a thread, where next() hands out 0, 1, 2, ... to whoever asks
  /// first. From n on there is nothing to do.
  template <class Body>
  void share(std::int32_t n, Body body) const {
    std::atomic<std::int32_t> at{0};
    const std::int32_t workers = std::min(n, count_);
    run(workers, workers, [&](std::int32_t, std::int32_t, std::int32_t) { body([&] { return at++; }); });
  }

 private:
  std::int32_t count_;
};

}  // namespace isimp
