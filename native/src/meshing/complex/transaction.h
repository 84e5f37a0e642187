#pragma once

#include <tuple>

#include "isimp/core/check.h"

namespace isimp::meshing {

/// The changes of some parts since the start of the transaction, which can be undone. A part is a State, or an array of
/// another class (`Logged`).
///
/// One at a time for each part. A transaction that ends without `commit` is rolled back.
/// Cost: `State::begin_transaction`, then O(size of the changes). `rollback` has the same cost as the changes.
template <class... Parts>
class Transaction {
 public:
  explicit Transaction(Parts&... parts) : parts_(parts...) { (parts.begin_transaction(), ...); }
  ~Transaction() {
    if (is_open_) rollback();
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  void commit() {
    end([](auto& part) { part.commit(); });
  }
  /// Restores the parts bit by bit.
  void rollback() {
    end([](auto& part) { part.rollback(); });
  }

 private:
  template <class Function>
  void end(Function fn) {
    ISIMP_ASSERT(is_open_, "a transaction ends once");
    std::apply([&](auto&... part) { (fn(part), ...); }, parts_);
    is_open_ = false;
  }

  std::tuple<Parts&...> parts_;
  bool is_open_ = true;
};

}  // namespace isimp::meshing
