#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "isimp/core/thread_count.h"

namespace isimp {

/// Threads that sleep until there is work. They are started at the first use and end with this.
class Workers {
 public:
  Workers() = default;
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;
  ~Workers();

  /// Calls body(piece), which must not throw, for each of `pieces` pieces: the first one on the calling thread, the
  /// others on any free thread, including this one. So no call waits for a thread that is not awake yet. While another
  /// call is running, all pieces run on the calling thread.
  void run(std::int32_t pieces, const std::function<void(std::int32_t)>& body);

 private:
  void start(std::int32_t threads);
  void work(std::unique_lock<std::mutex>& lock);

  std::mutex mutex_;
  std::condition_variable wake_, done_;
  const std::function<void(std::int32_t)>* body_ = nullptr;  // null: no call is running
  std::int32_t pieces_ = 0, next_ = 0, running_ = 0;
  bool ending_ = false;
  std::vector<std::jthread> threads_;
};

/// The only code that starts threads: loops cut into pieces that threads share, without busy waiting.
///
/// The results of the pieces must not depend on the number of pieces; the caller ensures this. The threads last from
/// one loop to the next, and as long as a copy of this. Waking one costs some 10 us, so short loops are left to the
/// caller's thread.
class Threads {
 public:
  /// \param count  see thread_count()
  explicit Threads(std::int32_t count)
      : count_(thread_count(count)), workers_(count_ > 1 ? std::make_shared<Workers>() : nullptr) {}

  /// The number of pieces into which `run` will cut n steps.
  /// \param least  steps below which a piece is not worth a thread
  [[nodiscard]] std::int32_t pieces(std::int32_t n, std::int32_t least = 1 << 14) const {
    return std::clamp(n / least, 1, count_);
  }

  /// Calls body(piece, begin, end) for each of `pieces` pieces of [0, n), the first one on the caller's thread. Throws
  /// the first exception of a piece.
  template <class Body>
  void run(std::int32_t n, std::int32_t pieces, Body body) const {
    const auto edge = [&](std::int32_t piece) {
      return static_cast<std::int32_t>(static_cast<std::int64_t>(n) * piece / pieces);
    };
    if (pieces <= 1 || !workers_) {
      for (std::int32_t piece = 0; piece < pieces; ++piece) body(piece, edge(piece), edge(piece + 1));
      return;
    }
    std::vector<std::exception_ptr> failure(static_cast<std::size_t>(pieces));
    workers_->run(pieces, [&](std::int32_t piece) {
      try {
        body(piece, edge(piece), edge(piece + 1));
      } catch (...) {
        failure[piece] = std::current_exception();
      }
    });
    for (const std::exception_ptr& e : failure)
      if (e) std::rethrow_exception(e);
  }
  template <class Body>
  void run(std::int32_t n, Body body) const {
    run(n, pieces(n), body);
  }

  /// For steps of unequal length: calls body(next) once a thread, where next() returns 0, 1, 2, ... in the order of the
  /// calls. From n on there is nothing to do.
  template <class Body>
  void share(std::int32_t n, Body body) const {
    std::atomic<std::int32_t> at{0};
    const std::int32_t workers = std::min(n, count_);
    run(workers, workers, [&](std::int32_t, std::int32_t, std::int32_t) { body([&] { return at++; }); });
  }

  /// As `share`, for blocks of [0, n), each of `size` steps but the last: calls body(block, begin, end) for each.
  template <class Body>
  void blocks(std::int32_t n, std::int32_t size, Body body) const {
    const std::int32_t count = n / size + (n % size > 0);
    share(count, [&](const auto& next) {
      for (std::int32_t block = next(); block < count; block = next())
        body(block, block * size, std::min(n - block * size, size) + block * size);
    });
  }

 private:
  std::int32_t count_;
  std::shared_ptr<Workers> workers_;
};

}  // namespace isimp
