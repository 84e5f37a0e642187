#pragma once

#include <bit>
#include <filesystem>
#include <stdexcept>

#include "isimp/mesh/io.h"
#include "isimp/mesh/mesh.h"
#include "tests.h"

namespace isimp::checks {

/// Tests with a folder of their own, removed afterwards.
class InFolder : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  const std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("isimp_" + std::to_string(std::random_device{}()));
};

/// Two quads and a triangle: a small house front.
inline const PolygonSoup kHouse{
    {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 1.5, 0.1}, {2, 0, 1e-3}, {2, 1, 1e-3}},
    {0, 1, 2, 3, 3, 2, 4, 1, 5, 6, 2},
    {0, 4, 7}};

/// The bytes of a value as a file of this byte order has them.
template <class T>
std::string raw(T value, bool big = false) {
  auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if (big != (std::endian::native == std::endian::big)) std::reverse(bytes.begin(), bytes.end());
  return {bytes.data(), bytes.size()};
}

/// A kind of repair of a cleaned mesh. \throws std::out_of_range if there was none of it.
inline const Repair& repair(const Mesh& mesh, const std::string& key) {
  for (const Repair& r : mesh.report().repairs)
    if (r.what == key) return r;
  throw std::out_of_range(key);
}
inline std::int64_t repaired(const Mesh& mesh, const std::string& key) { return repair(mesh, key).count; }

}  // namespace isimp::checks
