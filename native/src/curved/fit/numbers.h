#pragma once

#include <cstddef>
#include <cstdint>

/// Numbers that several steps share.
namespace isimp::curved {

// tuned round
inline constexpr double kFullTurn = 0.92;       ///< share of a turn, a sphere, a border or points that counts as all
inline constexpr double kCrease = 0.866;        ///< cosine between normals of points: a crease lies between others
inline constexpr double kSquare = 0.1;          ///< cosine between directions that are square
inline constexpr double kAlike = 2;             ///< nearnesses: axes and radii that are the same, planes that touch
inline constexpr double kReach = 1.4;           ///< times the nearness and its turn: a surface takes such points in
inline constexpr double kMostOfSurface = 0.85;  ///< share of the area of a surface that is most of it
inline constexpr double kNearlyAsWell = 1.3;    ///< times the distance: a simpler kind may be that much worse
inline constexpr double kPiece = 0.25;          ///< share of the area of a cell: smaller pieces are no cells
inline constexpr double kGood = 0.2;            ///< times the nearness, of a surface from its points: it is good
inline constexpr double kSpeck = 0.02;          ///< share of the area of a region, or of a small part
inline constexpr double kLeastArea = 0.01;      ///< share of the area of the whole mesh, of a curved surface
inline constexpr std::size_t kLeastPoints = 6;  ///< least number of points of a curved surface
inline constexpr std::size_t kMostSamples =
    500;  ///< number of faces, about, that a surface is compared with or fitted to
inline constexpr std::int32_t kMostStrips = 120;  ///< limit: segments of an extrusion
inline constexpr int kCorners = 48;               ///< number of corners, about, of the profile of a bend

}  // namespace isimp::curved
