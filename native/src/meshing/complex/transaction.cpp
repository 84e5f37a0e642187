#include "complex/transaction.h"

#include "isimp/core/check.h"

namespace isimp::meshing {

Transaction::Transaction(State& state) : s_(state) {
  ISIMP_ASSERT(s_.labels.touched.empty() && s_.pending_.united.empty() && !s_.complex.is_pending(),
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
  s_.pending_ = {};
  is_open_ = false;
}

}  // namespace isimp::meshing
