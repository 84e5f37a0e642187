#include <mutex>
#include <thread>

#include "isimp/core/thread_count.h"
#include "isimp/core/threads.h"
#include "tests.h"

namespace isimp {
namespace {

TEST(Threads, CutALoopWithoutGapsAndPassOnExceptions) {
  const Threads threads(3);
  std::vector<int> seen(100, 0);
  threads.run(100, 3, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (std::int32_t i = begin; i < end; ++i) ++seen[i];
  });
  EXPECT_EQ(seen, std::vector<int>(100, 1));
  EXPECT_EQ(threads.pieces(10), 1);
  EXPECT_EQ(threads.pieces(1 << 20), 3);
  EXPECT_THROW(threads.run(3, 3,
                           [](std::int32_t k, std::int32_t, std::int32_t) {
                             if (k == 2) throw Cancelled();
                           }),
               Cancelled);
}

TEST(Threads, AreNeverMoreThanAMachineHas) {
  EXPECT_GE(thread_count(0), 1);
  EXPECT_EQ(thread_count(1), 1);
  EXPECT_EQ(thread_count(8), 8);
  const std::int32_t most = thread_count(std::numeric_limits<std::int32_t>::max());
  EXPECT_GE(most, kMostThreads);
  EXPECT_LE(most, std::max(kMostThreads, thread_count(0)));
  EXPECT_EQ(Threads(100'000).pieces(1 << 30, 1), most);
  EXPECT_EQ(startable_threads(2), 2);
  EXPECT_LE(startable_threads(100'000), most);
}

TEST(Threads, HandOutEachStepOnce) {
  std::vector<std::atomic<int>> seen(1000);
  Threads(4).share(1000, [&](const auto& next) {
    for (std::int32_t i = next(); i < 1000; i = next()) ++seen[i];
  });
  for (const std::atomic<int>& times : seen) EXPECT_EQ(times, 1);
}

TEST(Threads, CutALoopIntoBlocksThatDoNotDependOnHowManyThereAre) {
  for (const std::int32_t count : {1, 2, 5})
    for (const std::int32_t n : {0, 1, 9, 10, 11, 95}) {
      std::vector<std::int32_t> block(n, -1);
      Threads(count).blocks(n, 10, [&](std::int32_t k, std::int32_t begin, std::int32_t end) {
        for (std::int32_t i = begin; i < end; ++i) block[i] = k;
      });
      for (std::int32_t i = 0; i < n; ++i) EXPECT_EQ(block[i], i / 10) << count << " threads, " << n << " steps";
    }
}

// A thread that has yet to begin is not waited for, but one that has begun is.
TEST(Threads, AreThereForOneLoopAfterAnother) {
  const Threads threads(4), copy = threads;
  for (int round = 0; round < 2000; ++round) {
    std::vector<std::int32_t> seen(8, 0);
    (round % 2 == 0 ? threads : copy).share(8, [&](const auto& next) {
      for (std::int32_t i = next(); i < 8; i = next()) seen[i] = i + round;
    });
    ASSERT_EQ(std::accumulate(seen.begin(), seen.end(), 0), 28 + 8 * round);
  }
}

TEST(Threads, ALoopInsideALoopIsDoneWhereItIs) {
  const Threads threads(3);
  std::atomic<int> elsewhere{0}, steps{0};
  threads.run(6, 6, [&](std::int32_t, std::int32_t, std::int32_t) {
    const auto here = std::this_thread::get_id();
    threads.run(5, 5, [&](std::int32_t, std::int32_t, std::int32_t) {
      ++steps;
      elsewhere += std::this_thread::get_id() != here;
    });
  });
  EXPECT_EQ(steps, 30);
  EXPECT_EQ(elsewhere, 0);
}

// Each of three pieces waits until all have begun, which one thread alone could not reach.
TEST(Threads, WorkSideBySide) {
  std::atomic<int> begun{0};
  std::mutex mutex;
  std::set<std::thread::id> ids;
  Threads(3).run(3, 3, [&](std::int32_t, std::int32_t, std::int32_t) {
    ++begun;
    while (begun < 3) std::this_thread::yield();
    const std::lock_guard lock(mutex);
    ids.insert(std::this_thread::get_id());
  });
  EXPECT_EQ(ids.size(), 3U);
}

}  // namespace
}  // namespace isimp
