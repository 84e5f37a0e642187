#include "isimp/core/threads.h"

#include <system_error>

namespace isimp {

Workers::~Workers() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  threads_.clear();  // waits for their ends
}

void Workers::run(std::int32_t pieces, const std::function<void(std::int32_t)>& body) {
  std::unique_lock lock(mutex_);
  if (body_) {
    lock.unlock();
    for (std::int32_t piece = 0; piece < pieces; ++piece) body(piece);
    return;
  }
  start(pieces - 1);
  body_ = &body;
  pieces_ = pieces;
  next_ = 0;
  for (std::int32_t piece = 1; piece < pieces; ++piece) wake_.notify_one();
  work(lock);
  done_.wait(lock, [&] { return running_ == 0; });
  body_ = nullptr;
}

/// Runs pieces until none is left.
void Workers::work(std::unique_lock<std::mutex>& lock) {
  while (next_ < pieces_) {
    const std::int32_t piece = next_++;
    ++running_;
    lock.unlock();
    (*body_)(piece);
    lock.lock();
    --running_;
  }
}

void Workers::start(std::int32_t threads) {
  try {
    while (static_cast<std::int32_t>(threads_.size()) < threads)
      threads_.emplace_back([this] {
        std::unique_lock lock(mutex_);
        while (true) {
          wake_.wait(lock, [&] { return ending_ || next_ < pieces_; });
          if (ending_) return;
          work(lock);
          if (running_ == 0) done_.notify_one();
        }
      });
  } catch (const std::system_error&) {  // the system starts no more threads: the work continues with fewer
  }
}

}  // namespace isimp
