#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "hull.h"
#include "solid.h"

namespace isimp::convex {

/// A connected part of a solid: some cells, and their hull.
struct Piece {
  std::vector<std::int32_t> cells;
  double volume = 0;
  ConvexPart hull = {};  ///< its corners are rounded to a millionth of the diagonal

  [[nodiscard]] double missing() const { return hull.volume - volume; }
};

/// The cells inside a solid and where they touch.
class Pieces {
 public:
  Pieces(const Solid& solid, Cells&& cells, Job& job);

  /// The cells of one piece alone, and that piece in terms of these.
  [[nodiscard]] std::pair<Pieces, Piece> alone(const Piece& piece) const;

  /// The connected pieces of the solid.
  [[nodiscard]] std::vector<Piece> whole() const;

  /// The planes that could cut a piece, the one that leaves least missing first.
  [[nodiscard]] std::vector<std::int32_t> choices(const Piece& piece, Job& job) const;

  /// The connected parts of a piece on both sides of a plane.
  std::vector<Piece> cut(const Piece& piece, std::int32_t plane);

  /// Whether the hull of a piece has free space farther from the solid than the tolerance.
  [[nodiscard]] bool fills_space(const Piece& piece, Job& job) const;

  /// The corners of all cells of a piece.
  [[nodiscard]] std::vector<Vec3> corners(const Piece& piece) const;

  /// Two pieces as one.
  [[nodiscard]] Piece joined(const Piece& a, const Piece& b) const;

  /// The pairs of pieces that touch; the lower number first, rising.
  [[nodiscard]] std::vector<std::array<std::int32_t, 2>> touching(const std::vector<Piece>& pieces) const;

 private:
  /// The polygon between two cells: it is a face of both, or a part of one.
  struct Contact {
    std::int32_t below = 0, above = 0;  ///< cells, by the normal of the plane
    std::int32_t plane = 0;
    Loop loop;
  };
  /// A plane that could cut a piece.
  struct Chance {
    std::int32_t plane = 0;
    double saved = 0;  ///< an estimate: area of faces, times how deep they lie below the hull
  };

  void find_contacts(Job& job);
  void add_contact(Contact&& contact);
  [[nodiscard]] std::vector<std::int32_t> chances(const Piece& piece) const;
  [[nodiscard]] std::vector<Piece> virtual_cut(const Piece& piece, std::int32_t plane) const;
  void divide_cells(const Piece& piece, std::int32_t plane);
  [[nodiscard]] std::vector<Piece> connected(const std::vector<std::int32_t>& cells) const;
  [[nodiscard]] Vec3 on_grid(const Vec3& p) const;
  [[nodiscard]] ConvexPart hull(const std::vector<std::int32_t>& cells) const;

  Pieces() = default;

  const Solid* solid_ = nullptr;
  double grid_ = 0;  // corners of hulls are multiples of it
  std::shared_ptr<const std::vector<Cell>> outside_;
  std::vector<Cell> cells_;
  std::vector<Contact> contacts_;
  std::vector<std::vector<std::int32_t>> contacts_of_;
  mutable std::vector<std::int32_t> place_;  // by cell: index in the piece at hand; -1: in none
};

}  // namespace isimp::convex
