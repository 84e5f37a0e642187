#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "complex/state.h"

namespace isimp::meshing {

/// The changes of a State since the start of the transaction. They can be undone: all of them, exactly, or some.
///
/// A pass applies many changes, finds new defects and undoes the changes that caused them. So apart from `rollback`
/// there are functions that undo one union, or the corners of one piece. `State::update_in_place` then updates the
/// polygons, with corners at their old places.
///
/// One at a time. A transaction that ends without `commit` is rolled back.
/// Pre: the state is up to date.
/// Cost: O(pieces) to begin; from then on O(size of the changes), `rollback` included.
class Transaction {
 public:
  explicit Transaction(State& state);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  void commit();
  /// Restores labels, pieces, planes, diagonals, corners, polygons and positions bit by bit, the numbers of polygons
  /// included.
  void rollback();

  // The positions of corners at the start of the transaction. All functions below restore the state of that time.
  [[nodiscard]] const Vec3& place_before(std::int32_t corner) const;
  void restore_place(std::int32_t corner);
  /// Restores the places of all corners.
  void restore_places();

  /// Restores the diagonals of a piece.
  void restore_diagonals(std::int32_t piece);
  /// Restores the diagonals of all pieces.
  /// \return the pieces whose diagonals had changed
  std::vector<std::int32_t> restore_diagonals();
  /// Restores the corners of a piece and its diagonals.
  void restore_corners(std::int32_t piece);
  /// Undoes a `State::unite` of two pieces and restores their labels and corners.
  /// Cost: O(faces of the absorbed piece + boundaries of both).
  void part_again(std::int32_t kept, std::int32_t gone);

 private:
  /// The faces that a piece had.
  [[nodiscard]] std::vector<std::int32_t> faces_before(std::int32_t piece) const;

  State& s_;
  bool is_open_ = true;
};

}  // namespace isimp::meshing
