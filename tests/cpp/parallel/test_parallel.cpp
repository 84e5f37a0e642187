#include "isimp/parallel/backend.h"
#include "tests.h"

namespace isimp::parallel {
namespace {

struct Input {
  std::vector<float> faces;
  std::vector<std::int32_t> labels;
  std::int32_t regions = 0;
};

/// Faces in all directions with areas over six decades; every eleventh is skipped, the labels come in short runs.
Input scattered(std::int32_t count, std::int32_t regions) {
  Input in;
  in.regions = regions;
  std::mt19937 random(7);
  const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
  std::int32_t label = 0;
  for (std::int32_t i = 0; i < count; ++i) {
    const double z = 2 * uniform() - 1, angle = 6.283185307 * uniform(), r = std::sqrt(1 - z * z);
    for (const double number : {r * std::cos(angle), r * std::sin(angle), z, std::pow(10.0, -6 * uniform())})
      in.faces.push_back(static_cast<float>(number));
    if (random() % 5 == 0) label = static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(regions));
    in.labels.push_back(i % 11 == 0 ? -1 : label);
  }
  return in;
}

std::vector<RegionSum> fit(const Input& in, std::int32_t threads = 1, const char* name = "cpu") {
  return backend(name).fit(in.faces, in.labels, in.regions, threads);
}

/// Every sum within the promised error of fit() of the sum of a plain loop.
void expect_sums(const Input& in, const std::vector<RegionSum>& sums) {
  ASSERT_EQ(sums.size(), static_cast<std::size_t>(in.regions));
  std::vector<std::array<long double, 4>> exact(sums.size(), {0, 0, 0, 0});
  std::vector<int> faces(sums.size(), 0);
  float largest = 0;
  for (std::size_t i = 0; i < in.labels.size(); ++i) {
    const float* f = &in.faces[4 * i];
    largest = std::max(largest, f[3]);
    if (in.labels[i] < 0) continue;
    const auto r = static_cast<std::size_t>(in.labels[i]);
    ++faces[r];
    exact[r][0] += f[3];
    for (int k = 0; k < 3; ++k) exact[r][k + 1] += static_cast<long double>(f[3]) * f[k];
  }
  const double step = std::ldexp(static_cast<double>(in.labels.size()) * largest, -60);
  for (std::size_t r = 0; r < sums.size(); ++r) {
    const double off = faces[r] * step / 2 + 1e-15 * static_cast<double>(exact[r][0]);
    EXPECT_NEAR(sums[r].area, static_cast<double>(exact[r][0]), off) << "region " << r;
    EXPECT_NEAR(sums[r].x, static_cast<double>(exact[r][1]), off) << "region " << r;
    EXPECT_NEAR(sums[r].y, static_cast<double>(exact[r][2]), off) << "region " << r;
    EXPECT_NEAR(sums[r].z, static_cast<double>(exact[r][3]), off) << "region " << r;
  }
}

std::string said(const Input& in, std::int32_t threads = 1) {
  return message_of([&] { fit(in, threads); });
}

TEST(Parallel, AHandMadeSumIsExact) {
  const Input in{{1, 0, 0, 2, 0, 0, -1, 0.5, 0.6F, 0, 0.8F, 4, 0, 1, 0, 8}, {1, 0, 1, -1}, 3};
  const std::vector<RegionSum> sums = fit(in);
  ASSERT_EQ(sums.size(), 3U);
  EXPECT_EQ(sums[0], (RegionSum{0.5, 0, 0, -0.5}));
  EXPECT_EQ(sums[1], (RegionSum{6, 2 + 4.0 * 0.6F, 0, 4.0 * 0.8F}));
  EXPECT_EQ(sums[2], RegionSum{});
}

TEST(Parallel, SumsAgreeWithAPlainLoop) {
  for (const auto& [count, regions] : {std::pair{1, 1}, {15, 2}, {16, 1}, {17, 3}, {100'000, 1}, {100'000, 400}}) {
    SCOPED_TRACE(testing::Message() << count << " faces, " << regions << " regions");
    const Input in = scattered(count, regions);
    expect_sums(in, fit(in));
  }
}

TEST(Parallel, MoreRegionsThanFacesLeaveEmptyOnes) {
  const Input in = scattered(1000, 50'000);
  expect_sums(in, fit(in, 2));
}

TEST(Parallel, NoFacesAndNoRegionsAreFine) {
  EXPECT_EQ(fit({{}, {}, 3}), std::vector<RegionSum>(3));
  EXPECT_TRUE(fit({{0, 0, 1, 1}, {-1}, 0}).empty());
  EXPECT_TRUE(fit({{}, {}, 0}).empty());
}

TEST(Parallel, FacesWithoutAreaSumToZero) {
  EXPECT_EQ(fit({{0, 0, 1, 0, 0, 0, 0, 0}, {0, 0}, 1}), std::vector<RegionSum>(1));
}

TEST(Parallel, TheSmallestAndTheLargestAreasFit) {
  for (const float area : {std::numeric_limits<float>::denorm_min(), 3e38F}) {
    const Input in{{0, 0, 1, area, 0, 0, 1, area}, {0, 0}, 1};
    EXPECT_EQ(fit(in).at(0), (RegionSum{2.0 * area, 0, 0, 2.0 * area}));
  }
}

TEST(Parallel, EveryBackEndAndThreadCountGivesTheSameBits) {
  const Input in = scattered(200'003, 37);
  const std::vector<RegionSum> one = fit(in, 1);
  for (const std::string& name : backends())
    for (const std::int32_t threads : {0, 1, 2, 3, 8, 61})
      EXPECT_EQ(fit(in, threads, name.c_str()), one) << name << ", " << threads << " threads";
}

TEST(Parallel, TheOrderOfTheFacesDoesNotChangeABit) {
  const Input in = scattered(10'000, 7);
  Input reversed{{}, {in.labels.rbegin(), in.labels.rend()}, in.regions};
  for (std::size_t i = in.labels.size(); i-- > 0;)
    reversed.faces.insert(reversed.faces.end(), &in.faces[4 * i], &in.faces[4 * i] + 4);
  EXPECT_EQ(fit(reversed, 2), fit(in, 2));
}

TEST(Parallel, BadInputIsNamed) {
  const Input good{{0, 0, 1, 1, 0, 0, 1, 1}, {0, 1}, 2};
  EXPECT_EQ(said(good), "no error");
  EXPECT_EQ(said(good, -1), "threads must be at least 0, got -1");
  Input in = good;
  in.regions = -4;
  EXPECT_EQ(said(in), "regions must be at least 0, got -4");
  in = good;
  in.faces.pop_back();
  EXPECT_EQ(said(in), "fitting wants 4 numbers a label, but got 7 for 2 labels");
  for (const std::int32_t label : {-2, 2}) {
    in = good;
    in.labels[1] = label;
    EXPECT_EQ(said(in), "face 1 has label " + std::to_string(label) + ", but there are 2 regions");
  }
  for (const auto& [place, number] : {std::pair{0, NAN}, {2, 1.1F}, {3, -1.0F}, {3, NAN}, {3, INFINITY}}) {
    in = good;
    in.faces[4 + place] = number;
    EXPECT_EQ(said(in).substr(0, 68), "face 1 needs a unit normal and a finite area that is not negative, b");
  }
}

TEST(Backend, TheCpuIsAlwaysThereAndFirst) { EXPECT_EQ(backends().at(0), "cpu"); }

TEST(Backend, TheErrorForAnUnknownNameListsTheKnownOnes) {
  std::string names = "cpu";
  if (backends().size() > 1) names += ", cuda";
  EXPECT_EQ(message_of([] { (void)backend("tpu"); }), "unknown back end 'tpu'; there is: " + names);
}

TEST(Backend, CudaWorksOrGivesAReason) {
  if (backends().size() > 1) {
    EXPECT_EQ(&backend("cuda"), &backend("cuda"));
    EXPECT_NE(&backend("cuda"), &backend("cpu"));
    return;
  }
  const std::string message = message_of([] { (void)backend("cuda"); });
  const std::string start = "back end 'cuda' is not available here: ", end = "; there is: cpu";
  EXPECT_TRUE(message.starts_with(start) && message.ends_with(end)) << message;
  EXPECT_GT(message.size(), start.size() + end.size());
}

}  // namespace
}  // namespace isimp::parallel
