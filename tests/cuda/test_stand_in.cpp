// The host side of the CUDA back end, run on a replacement for NVIDIA's runtime: see stand_in.h.

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "devices.h"
#include "isimp/core/errors.h"
#include "launch.h"
#include "stand_in.h"

namespace isimp::parallel {
namespace {

struct Surface {
  std::vector<float> faces;
  std::vector<std::int32_t> neighbours;
};

Surface strip(std::int32_t count) {
  Surface s;
  for (std::int32_t i = 0; i < count; ++i) {
    s.faces.insert(s.faces.end(), {0, 0, 1, 1});
    s.neighbours.insert(s.neighbours.end(), {i > 0 ? i - 1 : count, i + 1 < count ? i + 1 : count, count});
  }
  return s;
}

/// Kernels do nothing, so that memory holds its filling: here a survey without a bad face.
std::unique_ptr<Flooder> load(const Surface& surface, stand_in::Settings settings = {}) {
  settings.filling = 0x7f;
  stand_in::set(settings);
  return cuda_kernels().load({surface.faces, surface.neighbours});
}

Proxies some_proxies() { return {.seed = {0, 3}, .normal = {0, 0, 1, 0, 0, 1}, .centre = {0, 0, 0, 1, 1, 1}}; }

/// Each step of a flooder, by name.
std::vector<std::pair<const char*, std::function<void(Flooder&)>>> steps(Job& job) {
  return {{"queued", [&job](Flooder& f) { f.queued(some_proxies(), 1, job); }},
          {"naive",
           [&job](Flooder& f) {
             const std::vector<float> centre(3 * 1000, 0.5F);
             f.place(centre, {});
             f.naive(some_proxies(), 2, false, 1, job);
           }},
          {"fit", [](Flooder& f) { (void)f.fit(1); }},
          {"nearest", [](Flooder& f) { (void)f.nearest_faces(some_proxies(), 1); }},
          {"keep", [](Flooder& f) { f.keep(); }},
          {"pieces", [&job](Flooder& f) { f.cut_to_pieces(1, job); }},
          {"fill", [&job](Flooder& f) { f.fill(some_proxies(), 1, job); }},
          {"labels", [](Flooder& f) {
             std::vector<std::int32_t> labels(1000);
             f.labels(labels);
           }}};
}

TEST(StandIn, ADeviceIsFoundAndItsAbsenceTold) {
  stand_in::set({});
  EXPECT_EQ(cuda_obstacle(), "");
  stand_in::set({.devices = 0});
  EXPECT_EQ(cuda_obstacle(), "no CUDA device was found");
}

TEST(StandIn, LoadingTakesMemoryOfTheDeviceAndGivesItBack) {
  const Surface surface = strip(1000);
  auto flooder = load(surface);
  EXPECT_GT(stand_in::record().live, 3) << "the CUDA back end runs, not that of the CPU";
  EXPECT_GE(flooder->memory().bytes, 1000 * (16 + 12 + 4));
  flooder.reset();
  EXPECT_EQ(stand_in::record().live, 0);
  EXPECT_EQ(stand_in::record().misused, 0);
}

TEST(StandIn, EveryStepLaunchesAThreadForEachFaceInTheDefaultStream) {
  Job job;
  const Surface surface = strip(1000);
  for (const auto& [name, step] : steps(job)) {
    auto flooder = load(surface);
    stand_in::set({});
    step(*flooder);
    const stand_in::Record record = stand_in::record();
    EXPECT_EQ(record.other_streams, 0) << name;
    EXPECT_EQ(record.misused, 0) << name;
    for (const stand_in::Launch& launch : record.launches) EXPECT_LE(launch.threads, 1024U) << name;
  }
  for (const std::int32_t count : {10, 255, 256, 257, 100'000}) {
    const Surface other = strip(count);
    auto flooder = load(other);
    const auto launches = stand_in::record().launches;
    const auto blocks = static_cast<std::uint64_t>((count + 1 + 255) / 256);  // labels, including the sentinel's
    EXPECT_TRUE(std::ranges::any_of(launches, [&](const auto& l) { return l.blocks == blocks && l.threads == 256; }));
  }
}

TEST(StandIn, ACallThatFailsIsAnErrorInWordsAndLeavesNothingBehind) {
  Job job;
  const Surface surface = strip(1000);
  for (const int error : {stand_in::kOutOfMemory, stand_in::kIllegalAddress, stand_in::kLaunchFailure})
    for (const auto& [name, step] : steps(job)) {
      auto flooder = load(surface);
      stand_in::set({});
      step(*flooder);
      const std::int64_t calls = stand_in::record().calls;
      std::int64_t failures = 0;
      for (std::int64_t failing = 0; failing < calls; ++failing) {
        flooder.reset();
        flooder = load(surface);
        stand_in::set({.failing = failing, .error = error});
        try {
          step(*flooder);
        } catch (const Error& e) {
          const std::string said = e.what();
          EXPECT_NE(said.find("ing 1000 faces on back end 'cuda' "), std::string::npos) << name << ": " << said;
          EXPECT_NE(said.find("; back end 'cpu' can do the same in main memory, with the same result"),
                    std::string::npos)
              << said;
          ++failures;
        }
        stand_in::set({});
        step(*flooder);  // it can be used again
        flooder.reset();
        EXPECT_EQ(stand_in::record().live, 0) << name << " " << failing;
        EXPECT_EQ(stand_in::record().misused, 0) << name << " " << failing;
      }
      EXPECT_GT(failures, 0) << name << " " << error;
    }
}

TEST(StandIn, LoadingThatFailsLeavesNothingBehind) {
  const Surface surface = strip(1000);
  (void)load(surface);
  const std::int64_t calls = stand_in::record().calls;
  EXPECT_GT(calls, 8);
  for (std::int64_t failing = 0; failing < calls; ++failing) {
    try {
      (void)load(surface, {.failing = failing});
    } catch (const Error& e) {
      EXPECT_EQ(std::string(e.what()).rfind("loading 1000 faces on back end 'cuda' failed: ", 0), 0U) << e.what();
    }
    EXPECT_EQ(stand_in::record().live, 0) << failing;
    EXPECT_EQ(stand_in::record().misused, 0) << failing;
  }
}

TEST(StandIn, TooLittleMemoryIsTold) {
  const Surface surface = strip(1000);
  try {
    (void)load(surface, {.most = 20'000});
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()).rfind("loading 1000 faces on back end 'cuda' ran out of memory: ", 0), 0U);
  }
}

TEST(StandIn, SizesAboveTwoGigabytesArriveWhole) {
  const Surface surface = strip(4);
  const std::vector<std::int32_t> labels(4, 0);
  const std::int32_t regions = 400'000'000;
  stand_in::set({.filling = 0x7f, .most = 1 << 20});
  try {
    (void)cuda_kernels().fit(surface.faces, labels, regions, 1);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("12800 MB more were wanted"), std::string::npos) << e.what();
  }
  EXPECT_GE(stand_in::record().wanted.back(), std::size_t{32} * 400'000'000);
  EXPECT_EQ(stand_in::record().live, 0);
}

TEST(StandIn, LaunchesAreCountedInSixtyFourBits) {
  for (std::int64_t count = 10; count <= 100'000'000'000; count *= 10) {
    const std::int64_t blocks = blocks_for(count);
    EXPECT_GE(blocks * kThreadsOfBlock, count);
    EXPECT_LT((blocks - 1) * kThreadsOfBlock, count);
  }
  EXPECT_EQ(blocks_for(kMostOfLaunch), (std::int64_t{1} << 31) - 1);
}

}  // namespace
}  // namespace isimp::parallel
