#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "isimp/core/errors.h"
#include "isimp/mesh/io.h"

/// Files of text that change while they are read: their lines are counted first, and the lines read then may be other
/// ones. The arrays are those of either file or of a mixture, or a message names the fault; nothing is written outside
/// of them.
namespace isimp {
namespace {

namespace fs = std::filesystem;

constexpr int kVertices = 100, kFaces = 40'000;  // some 900,000 bytes: a single part

/// Lines of equal length, with any content.
std::string text(bool is_ply, int vertices, int faces, int corners) {
  std::string lines = "# a file of text\n";
  if (is_ply)
    lines = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(kVertices) +
            "\nproperty float x\nproperty float y\nproperty float z\nelement face " + std::to_string(kFaces) +
            "\nproperty list uchar int vertex_indices\nend_header\n";
  for (int row = 0; row < vertices + faces; ++row) {
    std::string line = row < vertices ? is_ply ? "0.25 1 2" : "v 0.25 1 2" : is_ply ? std::to_string(corners) : "f";
    for (int k = 0; row >= vertices && k < corners; ++k) line.append(" ").append(std::to_string(1 + (row + k) % 90));
    line.resize(24, ' ');
    lines += line + "\n";
  }
  return lines;
}

void save(const fs::path& path, const std::string& bytes) {
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);  // in place: never empty meanwhile
  if (!file) file.open(path, std::ios::binary | std::ios::out);
  file << bytes;
}

class PlainFiles : public testing::TestWithParam<bool> {};

TEST_P(PlainFiles, AFileThatIsWrittenMeanwhileDoesNoHarm) {
  const bool is_ply = GetParam();
  const fs::path path = fs::temp_directory_path() /
                        (std::string("isimp_written_meanwhile") +
                         std::to_string(testing::UnitTest::GetInstance()->random_seed()) + (is_ply ? ".ply" : ".obj"));
  const std::string before = text(is_ply, kVertices, kFaces, 3);
  const std::string others[] = {text(is_ply, kVertices, kFaces, 5), text(is_ply, kVertices, kFaces, 1),
                                text(is_ply, kVertices + 500, kFaces - 500, 3),
                                text(is_ply, kVertices - 50, kFaces + 50, 3)};
  int both = 0;
  for (const std::string& after : others) {
    for (int when = 1; when < 12; ++when) {
      save(path, before);
      fs::resize_file(path, before.size());
      Job job;
      int polls = 0;
      job.at_poll = [&] {
        if (++polls == when) save(path, after);
      };
      try {
        const PolygonSoup soup = read_polygons(path, job, 1);
        for (const std::int32_t v : soup.loops) ASSERT_LT(static_cast<std::size_t>(v), soup.vertices.size());
        ++both;
      } catch (const FileError&) {
        ++both;  // a file of PLY with other numbers of rows than in its header
      }
    }
  }
  EXPECT_EQ(both, 44);
  fs::remove(path);
}

INSTANTIATE_TEST_SUITE_P(Formats, PlainFiles, testing::Bool());

}  // namespace
}  // namespace isimp
