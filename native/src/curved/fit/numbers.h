#pragma once

#include <cstddef>
#include <cstdint>

/// Numbers that several steps share.
namespace isimp::curved {

// tuned round
inline constexpr double kMost = 0.9;          ///< share of a turn, an area or a border that counts as all of it
inline constexpr double kCrease = 0.866;      ///< cosine between normals of points: a crease lies between others
inline constexpr double kSquare = 0.1;        ///< cosine between directions that are square, sine between parallel ones
inline constexpr double kAlike = 2;           ///< nearnesses: axes and radii that are the same, planes that touch
inline constexpr double kReach = 1.5;         ///< times the nearness and its turn: a surface explains such points
inline constexpr double kHalf = 0.5;          ///< share of an area or a border that is the larger part
inline constexpr double kNearlyAsWell = 1.3;  ///< times the distance: a simpler kind, or cells, may be that much worse
inline constexpr double kQuarter = 0.25;      ///< share of a cell, a region or a border that is enough of it
inline constexpr double kGood = 0.2;          ///< times the nearness, of a surface from its points: it is good
inline constexpr double kSpeck = 0.01;        ///< share of an area or of squared normals: less does not count
inline constexpr double kFlat = 0.015;        ///< a second eigenvalue of normals, or 1 - |mean normal|: less is a plane
inline constexpr std::size_t kLeastPoints = 6;  ///< least number of points of a curved surface
inline constexpr std::size_t kMostSamples =
    500;  ///< number of faces, about, that a surface is compared with or fitted to
inline constexpr std::int32_t kMostStrips = 120;  ///< limit: segments of an extrusion
inline constexpr int kCorners = 40;               ///< number of corners, about, of the profile of a revolution

}  // namespace isimp::curved
