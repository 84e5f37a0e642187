#pragma once

#include <cstdlib>
#include <filesystem>

/// Real scans, which are not part of the repository.
namespace isimp::data {

/// The folder of test meshes: $ISIMP_DATA, else `../shared/data` beside the repository. It may not exist.
inline std::filesystem::path folder() {
  if (const char* named = std::getenv("ISIMP_DATA")) return named;
  return std::filesystem::path(ISIMP_SOURCE_DIR) / ".." / "shared" / "data";
}

/// Whether the test meshes are there; a test that needs them is skipped where they are not.
inline bool present() { return std::filesystem::is_directory(folder()); }

}  // namespace isimp::data
