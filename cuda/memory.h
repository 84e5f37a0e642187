#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <utility>
#include <vector>

/// A namespace for each back end: the same names mean other code there, and one program has several.
#ifndef ISIMP_DEVICE
#ifdef __CUDACC__
#define ISIMP_DEVICE on_cuda
#else
#define ISIMP_DEVICE on_cpu
#endif
#endif

/// Memory of the device, in place of Thrust's own, which allocates it again for every vector and every sum.
namespace isimp::parallel::ISIMP_DEVICE {

/// The device has too little memory left.
struct OutOfMemory final : std::bad_alloc {
  OutOfMemory(std::size_t more, std::size_t had) : wanted(more), held(had) {}
  std::size_t wanted, held;  ///< requested bytes, and bytes held already
};

// The back end's header defines these three.
/// \return null if the device has too little memory
inline void* device_new(std::size_t bytes);
inline void device_delete(void* block) noexcept;
/// Copies between host and device, in any direction, before later kernels run and after earlier ones.
inline void device_copy(void* to, const void* from, std::size_t bytes);

/// Blocks of the device's memory. A freed block is kept for the next request, until memory is needed in other sizes or
/// the whole is destroyed: a CUDA device stands still while it allocates. For one thread at a time.
class Memory {
 public:
  /// \param most  bytes that may be held at any time
  explicit Memory(std::size_t most) : most_(most) {}
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  ~Memory() { drop_free(); }

  /// \throws OutOfMemory
  void* take(std::size_t bytes) {
    if (bytes == 0) return nullptr;
    bytes = (bytes + kStep - 1) / kStep * kStep;
    Block* best = nullptr;
    for (Block& b : blocks_)
      if (!b.taken && b.bytes >= bytes && b.bytes <= 2 * bytes && (best == nullptr || b.bytes < best->bytes)) best = &b;
    if (best == nullptr) best = &make(bytes);
    best->taken = true;
    return best->at;
  }
  void give(void* at) noexcept {
    for (Block& b : blocks_)
      if (b.at == at) b.taken = false;
  }
  [[nodiscard]] std::size_t held() const { return held_; }
  /// The number of blocks that were allocated on the device.
  [[nodiscard]] std::int64_t allocations() const { return allocations_; }

 private:
  struct Block {
    void* at;
    std::size_t bytes;
    bool taken;
  };
  static constexpr std::size_t kStep = 256;

  Block& make(std::size_t bytes) {
    blocks_.reserve(blocks_.size() + 1);  // so that nothing can fail once the block exists
    void* at = allowed(bytes) ? device_new(bytes) : nullptr;
    if (at == nullptr) {
      drop_free();
      at = allowed(bytes) ? device_new(bytes) : nullptr;
    }
    if (at == nullptr) throw OutOfMemory(bytes, held_);
    ++allocations_;
    held_ += bytes;
    return blocks_.emplace_back(Block{at, bytes, false});
  }
  [[nodiscard]] bool allowed(std::size_t bytes) const { return held_ <= most_ && bytes <= most_ - held_; }
  void drop_free() noexcept {
    std::erase_if(blocks_, [&](const Block& b) {
      if (b.taken) return false;
      device_delete(b.at);
      held_ -= b.bytes;
      return true;
    });
  }

  std::size_t most_, held_ = 0;
  std::int64_t allocations_ = 0;
  std::vector<Block> blocks_;  // some tens
};

/// Numbers on the device.
template <class T>
class Array {
 public:
  explicit Array(Memory& memory, std::size_t size = 0) : memory_(&memory) { resize(size); }
  Array(const Array&) = delete;
  Array& operator=(const Array&) = delete;
  ~Array() { memory_->give(data_); }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] T* data() { return data_; }
  [[nodiscard]] const T* data() const { return data_; }

  /// The content is lost if the size is another.
  void resize(std::size_t size) {
    if (size == size_) return;
    memory_->give(std::exchange(data_, nullptr));
    size_ = 0;
    data_ = static_cast<T*>(memory_->take(size * sizeof(T)));
    size_ = size;
  }
  /// Copies numbers from the host or the device.
  void assign(const T* from, std::size_t size) {
    resize(size);
    device_copy(data_, from, size * sizeof(T));
  }
  /// Copies the first `count` numbers to the host.
  void read(T* to, std::size_t count) const { device_copy(to, data_, count * sizeof(T)); }
  [[nodiscard]] std::vector<T> read() const {
    std::vector<T> numbers(size_);
    read(numbers.data(), size_);
    return numbers;
  }
  void swap(Array& other) noexcept {  // both of one memory
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
  }

 private:
  Memory* memory_;
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

/// The caller's numbers, copied to the device.
template <class T>
class Copied {
 public:
  Copied(Memory& memory, std::span<const T> numbers) : numbers_(memory) {
    numbers_.assign(numbers.data(), numbers.size());
  }
  [[nodiscard]] const T* data() const { return numbers_.data(); }

 private:
  Array<T> numbers_;
};

}  // namespace isimp::parallel::ISIMP_DEVICE
