#pragma once

#include "complex/state.h"

namespace isimp::meshing {

/// The changes of a State since the start of the transaction, which can be undone.
///
/// One at a time. A transaction that ends without `commit` is rolled back.
/// Pre: the state is up to date.
/// Cost: O(charts) to begin; from then on O(size of the changes), `rollback` included.
class Transaction {
 public:
  explicit Transaction(State& state);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  void commit();
  /// Restores labels, charts, planes, diagonals, corners, polygons and positions bit by bit, the numbers of polygons
  /// included.
  void rollback();

 private:
  State& s_;
  bool is_open_ = true;
};

}  // namespace isimp::meshing
