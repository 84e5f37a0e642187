#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include "isimp/core/check.h"

namespace isimp::meshing {

/// An array with transactions that can be undone, as a whole or place by place: from `begin` to `commit` or `rollback`
/// the first write to a place saves its old value.
///
/// Cost: a write O(1), the saved value included; `rollback` O(places written to). The first transaction also reserves
/// memory for a number a place, of which only the written places are touched.
template <class T>
class Logged {
 public:
  Logged() = default;
  explicit Logged(std::size_t n, const T& value = T()) : now_(n, value) {}

  [[nodiscard]] std::size_t size() const { return now_.size(); }
  [[nodiscard]] bool empty() const { return now_.empty(); }
  const T& operator[](std::size_t i) const { return now_[i]; }
  [[nodiscard]] const T& back() const { return now_.back(); }
  [[nodiscard]] const T* data() const { return now_.data(); }
  [[nodiscard]] auto begin() const { return now_.begin(); }
  [[nodiscard]] auto end() const { return now_.end(); }
  operator const std::vector<T>&() const { return now_; }
  friend bool operator==(const Logged& a, const std::vector<T>& b) { return a.now_ == b; }

  /// A place to be written to.
  T& edit(std::size_t i) {
    if (is_new(i)) keep(i, now_[i]);
    return now_[i];
  }
  /// As `edit`, but the old value is moved and not copied.
  void set(std::size_t i, T value) {
    if (is_new(i)) keep(i, std::move(now_[i]));
    now_[i] = std::move(value);
  }
  /// The whole array, of which only these places may be written to: by several threads too.
  std::span<T> edit_all(std::span<const std::int32_t> places) {
    for (const std::int32_t i : places)
      if (is_new(i)) keep(i, now_[i]);
    return now_;
  }
  void push_back(T value) { now_.push_back(std::move(value)); }
  void pop_back() { resize(now_.size() - 1); }
  void resize(std::size_t n) {
    for (std::size_t i = n; i < now_.size(); ++i)
      if (is_new(i)) keep(i, std::move(now_[i]));
    now_.resize(n);
  }
  /// Not within a transaction.
  void assign(std::vector<T> all) {
    ISIMP_ASSERT(!is_open_, "a transaction can't take back all of an array");
    now_ = std::move(all);
  }

  void begin_transaction() {
    ISIMP_ASSERT(!is_open_, "one transaction at a time");
    if (now_.size() > room_) make_room(now_.size() + now_.size() / 2);
    size_ = now_.size();
    is_open_ = true;
  }
  void commit() {
    kept_.clear();
    is_open_ = false;
  }
  void rollback() {
    now_.resize(size_);
    for (auto& [i, value] : kept_) now_[i] = std::move(value);
    commit();
  }

  [[nodiscard]] bool in_transaction() const { return is_open_; }

  /// The number of places at the start of the transaction, or now if there is none.
  [[nodiscard]] std::size_t size_before() const { return is_open_ ? size_ : now_.size(); }
  // Within a transaction:
  /// The value of a place at the start of the transaction.
  [[nodiscard]] const T& before(std::size_t i) const { return is_kept(i) ? kept_[place_[i]].value : now_[i]; }
  /// Restores a place.
  void restore(std::size_t i) {
    if (is_kept(i)) now_[i] = kept_[place_[i]].value;
  }
  /// The places written to, each once.
  [[nodiscard]] std::vector<std::int32_t> written() const {
    std::vector<std::int32_t> places;
    places.reserve(kept_.size());
    for (const Kept& k : kept_) places.push_back(k.place);
    return places;
  }

 private:
  /// Without memory for it nothing changes.
  void make_room(std::size_t room) {
    auto* place = static_cast<std::uint32_t*>(std::calloc(room, sizeof(std::uint32_t)));
    if (!place) throw std::bad_alloc();
    place_.reset(place);
    room_ = room;
  }

  struct Kept {
    std::int32_t place;
    T value;
  };
  struct Free {
    void operator()(std::uint32_t* p) const { std::free(p); }
  };
  /// The value in `place_` may be arbitrary: the entry of `kept_` that it leads to must name the place.
  [[nodiscard]] bool is_kept(std::size_t i) const {
    return i < size_ && place_[i] < kept_.size() && kept_[place_[i]].place == static_cast<std::int32_t>(i);
  }
  [[nodiscard]] bool is_new(std::size_t i) const { return is_open_ && i < size_ && !is_kept(i); }
  void keep(std::size_t i, T value) {
    place_[i] = static_cast<std::uint32_t>(kept_.size());
    kept_.push_back({static_cast<std::int32_t>(i), std::move(value)});
  }

  std::vector<T> now_;
  std::vector<Kept> kept_;
  std::unique_ptr<std::uint32_t[], Free> place_;  // index in `kept_` of each saved place
  std::size_t size_ = 0, room_ = 0;
  bool is_open_ = false;
};

}  // namespace isimp::meshing
