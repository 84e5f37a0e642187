#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/core/types.h"
#include "isimp/mesh/face_graph.h"

namespace isimp::detail {

/// work: vertices or faces between two polls of a loop: about a millisecond of work.
inline constexpr std::size_t kPollEvery = 1 << 16;

/// Calls visit(i) for i in [0, n), polling the job between pieces.
template <class Visit>
void for_each_index(std::size_t n, Job& job, Visit visit) {
  for (std::size_t begin = 0; begin < n; begin += kPollEvery) {
    job.poll();
    const std::size_t end = std::min(n, begin + kPollEvery);
    for (std::size_t i = begin; i < end; ++i) visit(i);
  }
}

/// As above on several threads, in any order: visit(i) may write only memory that no other visit reads or writes.
template <class Visit>
void for_each_index(const Threads& threads, std::size_t n, Job& job, const Visit& visit) {
  threads.run(static_cast<std::int32_t>(n), [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    const auto from = static_cast<std::size_t>(begin);
    for_each_index(static_cast<std::size_t>(end) - from, job, [&](std::size_t i) { visit(from + i); });
  });
}

/// Calls visit(i, found) for i in [0, n) on several threads, each with a `found` of its own.
/// \return all of them joined, in the order of i if visit appends to `found`
template <class T, class Visit>
std::vector<T> gather(const Threads& threads, std::size_t n, Job& job, const Visit& visit) {
  const auto count = static_cast<std::int32_t>(n);
  const std::int32_t pieces = threads.pieces(count);
  std::vector<std::vector<T>> found(static_cast<std::size_t>(pieces));
  threads.run(count, pieces, [&](std::int32_t piece, std::int32_t begin, std::int32_t end) {
    const auto from = static_cast<std::size_t>(begin);
    std::vector<T> own;  // away from those of other threads in memory
    for_each_index(static_cast<std::size_t>(end) - from, job, [&](std::size_t i) { visit(from + i, own); });
    found[piece] = std::move(own);
  });
  for (std::int32_t piece = 1; piece < pieces; ++piece)
    found[0].insert(found[0].end(), found[piece].begin(), found[piece].end());
  return std::move(found[0]);
}

/// The sum of value(i) for i in [0, n), a whole number.
template <class Value>
std::int64_t count_of(const Threads& threads, std::size_t n, Job& job, const Value& value) {
  const auto steps = static_cast<std::int32_t>(n);
  std::vector<std::int64_t> sums(static_cast<std::size_t>(threads.pieces(steps)), 0);
  threads.run(
      steps, static_cast<std::int32_t>(sums.size()), [&](std::int32_t piece, std::int32_t begin, std::int32_t end) {
        std::int64_t sum = 0;
        const auto from = static_cast<std::size_t>(begin);
        for_each_index(static_cast<std::size_t>(end) - from, job, [&](std::size_t i) { sum += value(from + i); });
        sums[piece] = sum;
      });
  return std::accumulate(sums.begin(), sums.end(), std::int64_t{0});
}

/// The lowest i in [0, n) for which test(i) holds, else n. Not polled: checks of input come before a cancel.
template <class Test>
std::size_t find_first(const Threads& threads, std::size_t n, const Test& test) {
  const auto steps = static_cast<std::int32_t>(n);
  std::vector<std::int32_t> first(static_cast<std::size_t>(threads.pieces(steps)), steps);
  threads.run(steps, static_cast<std::int32_t>(first.size()),
              [&](std::int32_t piece, std::int32_t begin, std::int32_t end) {
                while (begin < end && !test(static_cast<std::size_t>(begin))) ++begin;
                if (begin < end) first[piece] = begin;
              });
  return static_cast<std::size_t>(*std::min_element(first.begin(), first.end()));
}

/// The bounding box of the vertices for which used(v) holds.
template <class Used>
Box box_of(std::span<const Vec3> vertices, const Threads& threads, Job& job, const Used& used) {
  const auto n = static_cast<std::int32_t>(vertices.size());
  std::vector<Box> boxes(static_cast<std::size_t>(threads.pieces(n)));
  threads.run(n, static_cast<std::int32_t>(boxes.size()),
              [&](std::int32_t piece, std::int32_t begin, std::int32_t end) {
                Box own;
                const auto from = static_cast<std::size_t>(begin);
                for_each_index(static_cast<std::size_t>(end) - from, job, [&](std::size_t i) {
                  if (used(from + i)) own.extend(vertices[from + i]);
                });
                boxes[piece] = own;
              });
  Box all;
  for (const Box& box : boxes) all.extend(box);
  return all;
}

/// 0, 1, 2, ...
template <class Numbers>
void number_all(const Threads& threads, Numbers& numbers, std::size_t n, Job& job) {
  numbers.resize(n);
  for_each_index(threads, n, job, [&](std::size_t i) { numbers[i] = static_cast<std::int32_t>(i); });
}

}  // namespace isimp::detail
