#include "complex/transaction.h"

#include <utility>

#include "isimp/core/check.h"

namespace isimp::meshing {

Transaction::Transaction(State& state) : s_(state) {
  ISIMP_ASSERT(s_.labels.touched.empty() && s_.united_.empty() && !s_.complex.is_pending(),
               "a transaction begins with a state that is up to date");
  s_.polygons_.close_gaps();
  State::for_each_array(s_, [](auto& array) { array.begin_transaction(); });
}

Transaction::~Transaction() {
  if (is_open_) rollback();
}

void Transaction::commit() {
  ISIMP_ASSERT(is_open_, "a transaction ends once");
  State::for_each_array(s_, [](auto& array) { array.commit(); });
  is_open_ = false;
}

void Transaction::rollback() {
  ISIMP_ASSERT(is_open_, "a transaction ends once");
  State::for_each_array(s_, [](auto& array) { array.rollback(); });
  s_.labels_.touched.clear();
  s_.complex_.drop_pending();
  s_.united_.clear();
  s_.handovers_.clear();
  s_.handed_.clear();
  s_.discs_.clear();
  s_.known_.clear();
  s_.at_home_.clear();
  is_open_ = false;
}

const Vec3& Transaction::place_before(std::int32_t corner) const { return s_.corners.position.before(corner); }

void Transaction::restore_place(std::int32_t corner) {
  ISIMP_ASSERT(is_open_, "what is taken back is of a transaction that has not ended");
  s_.corners_.position.restore(corner);
}

void Transaction::restore_places() {
  for (const std::int32_t c : s_.corners.position.written()) restore_place(c);
}

void Transaction::restore_diagonals(std::int32_t piece) {
  ISIMP_ASSERT(is_open_, "what is taken back is of a transaction that has not ended");
  s_.diagonals_.restore(piece);
}

std::vector<std::int32_t> Transaction::restore_diagonals() {
  std::vector<std::int32_t> others;
  for (const std::int32_t l : s_.diagonals.written())
    if (s_.diagonals[l] != s_.diagonals.before(l)) others.push_back(l);
  for (const std::int32_t l : others) restore_diagonals(l);
  return others;
}

void Transaction::restore_corners(std::int32_t piece) {
  restore_diagonals(piece);
  for (const std::int32_t h : s_.complex.loop(piece)) {
    const std::int32_t v = s_.mesh.from(h);
    if (s_.complex.is_corner(v) != s_.complex.was_corner(v)) s_.complex_.restore_corner(v);
  }
}

std::vector<std::int32_t> Transaction::faces_before(std::int32_t piece) const {
  const Labels& labels = s_.labels;
  std::vector<std::int32_t> faces{labels.pieces.before(piece).face};
  labels.face_marks.clear();
  labels.face_marks.add(faces[0]);
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (std::int32_t h = 3 * faces[i], end = h + 3; h < end; ++h) {
      const std::int32_t o = s_.mesh.opposite(h);
      if (o != kNone && labels.label.before(o / 3) == piece && labels.face_marks.add(o / 3)) faces.push_back(o / 3);
    }
  return faces;
}

void Transaction::part_again(std::int32_t kept, std::int32_t gone) {
  ISIMP_ASSERT(is_open_ && s_.labels.pieces[kept].face != kNone && s_.labels.pieces[gone].face == kNone &&
                   s_.labels.pieces.before(gone).face != kNone,
               "a piece that is parted again went into another one within the transaction");
  for (const std::int32_t f : faces_before(gone)) s_.labels_.label.restore(f);
  for (const std::int32_t l : {kept, gone}) {
    s_.labels_.pieces.restore(l);
    s_.planes_.restore(l);
    restore_diagonals(l);
    s_.labels_.touched.push_back(l);
    const std::span<const std::int32_t> loop = s_.complex.loop_before(l);
    s_.known_[l].assign(loop.begin(), loop.end());
  }
  for (const std::int32_t l : {kept, gone})
    for (const std::int32_t h : s_.complex.loop_before(l)) {
      const std::int32_t v = s_.mesh.from(h);
      if (s_.complex.is_corner(v) || s_.complex.was_corner(v)) s_.complex_.restore_corner(v);
    }
}

}  // namespace isimp::meshing
