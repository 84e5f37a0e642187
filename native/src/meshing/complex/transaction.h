#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "complex/state.h"

namespace isimp::meshing {

/// What is done to a State from here on, which can be taken back: all of it, exactly, or some of it.
///
/// Policies try many things at a time, look what has become faulty, and take back what is to blame. So beside
/// `rollback` there are functions that take back one union, or the corners of one piece. `State::update_in_place`
/// then updates the polygons, with corners where they were.
///
/// One at a time. A transaction that ends without `commit` is rolled back.
/// Pre: the state is up to date.
/// Cost: O(pieces) to begin; from then on that of what is changed, `rollback` included.
class Transaction {
 public:
  explicit Transaction(State& state);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  void commit();
  /// Makes labels, pieces, planes, diagonals, corners, polygons and positions what they were, bit by bit; the
  /// polygons' numbers too.
  void rollback();

  // Where corners were, as all of this is of when the transaction began.
  [[nodiscard]] const Vec3& place_before(std::int32_t corner) const;
  void restore_place(std::int32_t corner);
  /// Of all corners.
  void restore_places();

  /// Makes the diagonals of a piece what they were.
  void restore_diagonals(std::int32_t piece);
  /// Of all pieces.
  /// \return those whose diagonals were others
  std::vector<std::int32_t> restore_diagonals();
  /// Makes the corners of a piece and its diagonals what they were.
  void restore_corners(std::int32_t piece);
  /// Parts two pieces that `State::unite` has made one, with labels and corners as they were.
  /// Cost: O(faces of the one that was gone + their boundaries).
  void part_again(std::int32_t kept, std::int32_t gone);

 private:
  /// The faces that a piece had.
  [[nodiscard]] std::vector<std::int32_t> faces_before(std::int32_t piece) const;

  State& s_;
  bool is_open_ = true;
};

}  // namespace isimp::meshing
