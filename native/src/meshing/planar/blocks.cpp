#include "planar/blocks.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>

#include "isimp/core/symmetric.h"

namespace isimp::meshing::planar {

BlockSystem::BlockSystem(std::int32_t count, std::span<const std::array<std::int32_t, 2>> pairs)
    : count_(count), place_(count), entry_(pairs.size()), start_(count + 1, 0), diagonal_(count) {
  std::vector<Eigen::Triplet<double>> some;
  some.reserve(2 * pairs.size());
  for (const auto& [i, j] : pairs) {
    some.emplace_back(i, j, 1);
    some.emplace_back(j, i, 1);
  }
  for (std::int32_t k = 0; k < count; ++k) some.emplace_back(k, k, 1);  // without these the order is a bad one
  Eigen::SparseMatrix<double> pattern(count, count);
  pattern.setFromTriplets(some.begin(), some.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order(count);
  if (count > 0) Eigen::AMDOrdering<int>()(pattern, order);
  for (std::int32_t k = 0; k < count; ++k) place_[order.indices()[k]] = k;

  std::vector<std::array<std::int32_t, 2>> sorted;  // column, row
  sorted.reserve(pairs.size());
  for (const auto& [i, j] : pairs) sorted.push_back({std::max(place_[i], place_[j]), std::min(place_[i], place_[j])});
  const auto all = sorted;
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  for (const auto& [column, row] : sorted) {
    ++start_[column + 1];
    row_.push_back(row);
  }
  std::partial_sum(start_.begin(), start_.end(), start_.begin());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const auto at = std::lower_bound(sorted.begin(), sorted.end(), all[p]);
    entry_[p] = {static_cast<std::int32_t>(at - sorted.begin()), place_[pairs[p][0]] != all[p][1]};
  }
  block_.resize(row_.size());
  analyse();
  clear();
}

void BlockSystem::analyse() {
  parent_.assign(count_, -1);
  mark_.assign(count_, -1);
  reach_.resize(count_);
  path_.resize(count_);
  factor_start_.assign(count_ + 1, 0);
  std::vector<std::int32_t> size(count_, 0);
  for (std::int32_t k = 0; k < count_; ++k) {
    mark_[k] = k;
    for (std::int32_t p = start_[k]; p < start_[k + 1]; ++p)
      for (std::int32_t i = row_[p]; mark_[i] != k; i = parent_[i]) {
        if (parent_[i] < 0) parent_[i] = k;
        ++size[i];
        mark_[i] = k;
      }
  }
  std::partial_sum(size.begin(), size.end(), factor_start_.begin() + 1);
  factor_row_.resize(factor_start_.back());
  factor_.resize(factor_row_.size());
  inverse_.resize(count_);
  work_.resize(count_);
  unknown_.resize(count_);
  answer_.resize(count_);
}

void BlockSystem::clear() {
  std::fill(block_.begin(), block_.end(), Mat3(Mat3::Zero()));
  std::fill(diagonal_.begin(), diagonal_.end(), Mat3(Mat3::Zero()));
}

std::int32_t BlockSystem::reach(std::int32_t k) {
  std::int32_t top = count_;
  mark_[k] = k;
  for (std::int32_t p = start_[k]; p < start_[k + 1]; ++p) {
    std::int32_t length = 0;
    for (std::int32_t i = row_[p]; mark_[i] != k; i = parent_[i]) {
      path_[length++] = i;
      mark_[i] = k;
    }
    while (length > 0) reach_[--top] = path_[--length];
  }
  return top;
}

void BlockSystem::factorise() {
  fill_.assign(factor_start_.begin(), factor_start_.end() - 1);
  std::fill(mark_.begin(), mark_.end(), -1);
  for (std::int32_t k = 0; k < count_; ++k) {
    const std::int32_t top = reach(k);
    for (std::int32_t t = top; t < count_; ++t) work_[reach_[t]].setZero();
    for (std::int32_t p = start_[k]; p < start_[k + 1]; ++p) work_[row_[p]] = block_[p];
    Mat3 rest = diagonal_[k];
    for (std::int32_t t = top; t < count_; ++t) {
      const std::int32_t i = reach_[t];
      const Mat3 z = work_[i];
      for (std::int32_t p = factor_start_[i]; p < fill_[i]; ++p) work_[factor_row_[p]].noalias() -= factor_[p] * z;
      const Mat3 l = z.transpose() * inverse_[i];
      rest.noalias() -= l * z;
      factor_row_[fill_[i]] = k;
      factor_[fill_[i]++] = l;
    }
    inverse_[k] = balanced_inverse(rest);
  }
}

const std::vector<BlockSystem::Vec3>& BlockSystem::solve(std::span<const Vec3> right) {
  factorise();
  for (std::int32_t k = 0; k < count_; ++k) unknown_[place_[k]] = right[k];
  for (std::int32_t i = 0; i < count_; ++i)
    for (std::int32_t p = factor_start_[i]; p < fill_[i]; ++p)
      unknown_[factor_row_[p]].noalias() -= factor_[p] * unknown_[i];
  for (std::int32_t i = count_; i-- > 0;) {
    Vec3 x = inverse_[i] * unknown_[i];
    for (std::int32_t p = factor_start_[i]; p < fill_[i]; ++p)
      x.noalias() -= factor_[p].transpose() * unknown_[factor_row_[p]];
    unknown_[i] = x;
  }
  const bool finite = std::all_of(unknown_.begin(), unknown_.end(), [](const Vec3& x) { return x.allFinite(); });
  for (std::int32_t k = 0; k < count_; ++k) answer_[k] = finite ? unknown_[place_[k]] : Vec3(Vec3::Zero());
  return answer_;
}

}  // namespace isimp::meshing::planar
