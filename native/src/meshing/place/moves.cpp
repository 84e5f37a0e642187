#include "place/moves.h"

#include "isimp/core/sorted.h"

namespace isimp::meshing {
namespace {

constexpr int kRounds = 24;
constexpr int kRoundsOfRing = 3;  // rounds for each further ring of polygons whose corners are restored

}  // namespace

void Moves::settle(std::span<const std::int32_t> moved, const std::function<std::int32_t(std::int32_t)>& with) {
  judge(moved);
  for (int round = 0; round < kRounds; ++round) {
    job_.poll();
    std::vector<std::int32_t> pieces = worse(), corners;
    if (pieces.empty()) return transaction_.commit();
    for (int ring = 0; ring < round / kRoundsOfRing; ++ring) s_.add_neighbours(pieces);
    for (const std::int32_t l : pieces)
      s_.polygons.for_each_of(l, [&](std::int32_t q) {
        for (const std::int32_t c : s_.polygons.of(q)) {
          corners.push_back(c);
          if (const std::int32_t other = with(c); other != kNone) corners.push_back(other);
        }
      });
    sort_unique(corners);
    for (const std::int32_t c : corners) transaction_.restore_place(c);
    judge(corners);
  }
  transaction_.rollback();
  judge(moved);
}

bool Moves::keep_if_sound(std::span<const std::int32_t> moved) {
  judge(moved);
  if (worse().empty()) {
    transaction_.commit();
    return true;
  }
  transaction_.rollback();
  judge(moved);
  return false;
}

std::vector<std::int32_t> Moves::worse() const {
  const std::vector<bool> now = findings_.faulty();
  std::vector<std::int32_t> pieces;
  for (std::size_t l = 0; l < now.size(); ++l)
    if (now[l] && (l >= faulty_.size() || !faulty_[l])) pieces.push_back(static_cast<std::int32_t>(l));
  return pieces;
}

void Moves::judge(std::span<const std::int32_t> corners) {
  std::vector<std::int32_t> pieces;
  for (const std::int32_t c : corners)
    for (const std::int32_t q : s_.polygons.at(c)) pieces.push_back(s_.polygons.piece(q));
  sort_unique(pieces);
  findings_.judge(pieces);
}

}  // namespace isimp::meshing
