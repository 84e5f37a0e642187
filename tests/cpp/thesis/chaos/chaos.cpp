#include "chaos/chaos.h"

#include <ucontext.h>

#include <algorithm>
#include <csetjmp>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <numeric>
#include <random>
#include <unordered_map>
#include <vector>

namespace isimp::chaos {
namespace {

constexpr std::int64_t kBlock = 256;
constexpr std::size_t kStack = 1 << 16;
constexpr int kRubbish = 0xA5, kGone = 0xDD;

struct State {
  std::mt19937_64 random{1};
  std::int64_t failing = -1;
  Count count;
  std::unordered_map<void*, std::size_t> blocks;
};
State& state() {
  static State one;
  return one;
}

/// Threads of a launch that wait for each other: each takes the next number, and switches to another thread where it
/// waits. setjmp saves the same state as swapcontext, without a call of the system for every switch.
class Launch {
 public:
  Launch(std::vector<std::int64_t> order, const std::function<void(std::int64_t)>& kernel, std::size_t width)
      : order_(std::move(order)), kernel_(kernel), width_(std::min(width, order_.size())) {}

  void run() {
    current_launch() = this;
    static std::vector<std::unique_ptr<Fiber>> pool;  // stacks are dear
    while (pool.size() < width_) pool.push_back(std::make_unique<Fiber>());
    for (std::size_t k = 0; k < width_; ++k) {
      pool[k]->started = pool[k]->done = false;
      ready_.push_back(pool[k].get());
    }
    while (!ready_.empty()) {
      const std::size_t k = random(ready_.size());
      running_ = ready_[k];
      ready_[k] = ready_.back();
      ready_.pop_back();
      resume();
      if (!running_->done) ready_.push_back(running_);
    }
    current_launch() = nullptr;
  }

  void wait() {
    ++state().count.switches;
    Fiber* const self = running_;
    if (_setjmp(self->at) == 0) _longjmp(host_, 1);
  }

  static Launch*& current_launch() {
    static Launch* one = nullptr;
    return one;
  }

 private:
  struct Fiber {
    ucontext_t context{};
    std::jmp_buf at{};
    bool started = false, done = false;
    std::unique_ptr<char[]> stack = std::make_unique_for_overwrite<char[]>(kStack);
  };

  void resume() {
    if (_setjmp(host_) != 0) return;
    if (running_->started) _longjmp(running_->at, 1);
    running_->started = true;
    getcontext(&running_->context);
    running_->context.uc_stack.ss_sp = running_->stack.get();
    running_->context.uc_stack.ss_size = kStack;
    running_->context.uc_link = nullptr;
    makecontext(&running_->context, &Launch::enter, 0);
    setcontext(&running_->context);
  }

  static void enter() {
    Launch& launch = *current_launch();
    while (launch.next_ < launch.order_.size()) launch.kernel_(launch.order_[launch.next_++]);
    launch.running_->done = true;
    _longjmp(launch.host_, 1);
  }

  std::vector<std::int64_t> order_;
  const std::function<void(std::int64_t)>& kernel_;
  std::size_t next_ = 0;
  std::size_t width_;
  std::vector<Fiber*> ready_;
  Fiber* running_ = nullptr;
  std::jmp_buf host_{};
};

}  // namespace

void set(const Settings& settings) {
  state().random.seed(settings.seed);
  state().failing = settings.failing;
  state().count.allocations = state().count.misused = state().count.switches = 0;
}

Count count() {
  Count count = state().count;
  count.live = static_cast<std::int64_t>(state().blocks.size());
  return count;
}

std::size_t random(std::size_t below) { return state().random() % below; }

void run(std::int64_t begin, std::int64_t end, const std::function<void(std::int64_t)>& kernel) {
  std::vector<std::int64_t> blocks;
  for (std::int64_t at = begin; at < end; at += kBlock) blocks.push_back(at);
  std::ranges::shuffle(blocks, state().random);
  std::vector<std::int64_t> order;
  for (const std::int64_t at : blocks) {
    const auto first = static_cast<std::ptrdiff_t>(order.size());
    for (std::int64_t i = at; i < std::min(at + kBlock, end); ++i) order.push_back(i);
    std::shuffle(order.begin() + first, order.end(), state().random);
  }
  if (!order.empty()) Launch(std::move(order), kernel, 2 + random(2 * kBlock)).run();
}

void wait() {
  if (Launch* const launch = Launch::current_launch(); launch != nullptr) launch->wait();
}

void* allocate(std::size_t bytes) {
  if (state().count.allocations++ == state().failing) return nullptr;
  void* const block = std::malloc(bytes);
  if (block != nullptr) {
    std::memset(block, kRubbish, bytes);
    state().blocks[block] = bytes;
  }
  return block;
}

void release(void* block) noexcept {
  const auto at = state().blocks.find(block);
  if (at == state().blocks.end()) {
    ++state().count.misused;
    return;
  }
  std::memset(block, kGone, at->second);
  state().blocks.erase(at);
  std::free(block);
}

}  // namespace isimp::chaos
