#pragma once

#include <cstddef>

/// Numbers that several steps share.
namespace isimp::curved {

inline constexpr double kFullTurn = 0.92;       ///< share of a full turn, or of all of a sphere, that counts as that
inline constexpr double kCrease = 0.866;        ///< cosine between normals of points: a crease lies between others
inline constexpr double kSquare = 0.1;          ///< cosine between directions that are square
inline constexpr double kAlike = 2;             ///< nearnesses: axes and radii that are the same, planes that touch
inline constexpr double kReach = 1.4;           ///< times the nearness and its turn: a surface takes such points in
inline constexpr double kMost = 0.85;           ///< share of the area of a surface that is most of it
inline constexpr double kNearlyAsWell = 1.3;    ///< times the distance: a simpler kind may be that much worse
inline constexpr double kPiece = 0.25;          ///< share of the area of a cell: smaller pieces are no cells
inline constexpr double kLeastArea = 0.01;      ///< share of the area of the whole mesh, of a curved surface
inline constexpr std::size_t kLeastPoints = 6;  ///< of a curved surface
inline constexpr int kLeastBorder = 6;          ///< edges of a common border
inline constexpr int kCorners = 48;             ///< about so many has the profile of a bend

}  // namespace isimp::curved
