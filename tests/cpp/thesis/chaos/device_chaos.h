#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "chaos/chaos.h"
#include "memory.h"

#define ISIMP_KERNEL

#include "gather.h"

/// The device of chaos.h, for cuda/device.h.
namespace isimp::parallel::ISIMP_DEVICE {

inline constexpr const char* kName = "chaos";

inline void* device_new(std::size_t bytes) { return chaos::allocate(bytes); }
inline void device_delete(void* block) noexcept { chaos::release(block); }
inline void device_copy(void* to, const void* from, std::size_t bytes) {
  if (bytes > 0) std::memcpy(to, from, bytes);
}

template <class T>
using Readable = Copied<T>;

template <class Kernel>
void for_all(std::int64_t begin, std::int64_t end, Kernel kernel) {
  chaos::run(begin, end, [&](std::int64_t i) { kernel(i); });
}

template <class Kernel, class Value, class Merge>
Value reduce_all(Memory& memory, std::int64_t end, Kernel kernel, Value start, Merge merge) {
  const Array<char> scratch(memory, static_cast<std::size_t>(end) + 1);  // scratch memory as in Thrust
  std::vector<Value> values(static_cast<std::size_t>(end), start);
  chaos::run(0, end, [&](std::int64_t i) { values[static_cast<std::size_t>(i)] = kernel(i); });
  values.push_back(start);
  while (values.size() > 1) {
    std::swap(values[chaos::random(values.size())], values.back());
    const Value last = values.back();
    values.pop_back();
    Value& other = values[chaos::random(values.size())];
    other = chaos::random(2) == 0 ? merge(other, last) : merge(last, other);
  }
  return values.front();
}

enum class Order : std::uint8_t { relaxed };
inline constexpr Order kRelaxed = Order::relaxed;

/// Other threads may run before every operation, and no operation is divided.
template <class T>
class Shared {
 public:
  explicit Shared(T& number) : number_(number) {}
  [[nodiscard]] T load(Order /*order*/) const {
    chaos::wait();
    return number_;
  }
  void store(T value, Order /*order*/) const {
    chaos::wait();
    number_ = value;
  }
  T exchange(T value, Order /*order*/) const {
    chaos::wait();
    return std::exchange(number_, value);
  }
  bool compare_exchange_strong(T& expected, T value, Order /*order*/) const {
    chaos::wait();
    if (number_ == expected) {
      number_ = value;
      return true;
    }
    expected = number_;
    return false;
  }
  T fetch_add(T value, Order /*order*/) const {
    chaos::wait();
    return std::exchange(number_, number_ + value);
  }
  T fetch_min(T value, Order /*order*/) const {
    chaos::wait();
    return std::exchange(number_, std::min(number_, value));
  }
  T fetch_max(T value, Order /*order*/) const {
    chaos::wait();
    return std::exchange(number_, std::max(number_, value));
  }

 private:
  T& number_;
};
template <class T>
Shared<T> shared(T& number) {
  return Shared<T>(number);
}

class Threads {
 public:
  explicit Threads(std::int32_t /*wanted*/) {}
};

inline std::int32_t reserve(std::int32_t& count, std::int32_t more) { return shared(count).fetch_add(more, kRelaxed); }

/// Some steps at once, as on a device.
template <class Flood>
void repeat(const Flood& flood, std::int32_t step) {
  std::int32_t& steps = flood.progress->steps = 0;
  for (std::size_t left = 1 + chaos::random(4); left > 0 && flood.size(step) > 0; --left, ++steps, ++step) {
    const std::int64_t size = flood.size(step);
    for_all(0, size, [&](std::int64_t i) { flood.choose(i, step); });
    gather(flood.applied(step + 1), size);
  }
}

}  // namespace isimp::parallel::ISIMP_DEVICE
