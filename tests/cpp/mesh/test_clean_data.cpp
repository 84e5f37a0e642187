#include <filesystem>

#include "isimp/mesh/clean.h"
#include "isimp/mesh/io.h"
#include "labelled.h"
#include "tests.h"

namespace isimp {
namespace {

namespace fs = std::filesystem;

#ifdef ISIMP_SANITIZE  // ten times as slow; other builds take all
constexpr std::uintmax_t kLargestFile = 4 << 20;
constexpr std::array kThreads = {2};
#else
constexpr std::uintmax_t kLargestFile = 1 << 30;
constexpr std::array kThreads = {1, 2};
#endif

struct Read {
  PolygonSoup soup;
  Triangulation filled;
};

Read read(const fs::path& path) {
  Read result{read_polygons(path, job()), {}};
  result.filled = triangulate(result.soup, job());
  return result;
}

Mesh cleaned(const Read& read) { return clean(read.soup.vertices, read.filled.triangles, {}, job()); }

std::map<std::string, std::int64_t> repairs(const Mesh& mesh) {
  std::map<std::string, std::int64_t> counts;
  for (const Repair& r : mesh.report().repairs)
    if (r.count > 0) counts[r.what] = r.count;
  return counts;
}

class CleanData : public testing::Test {
 protected:
  void SetUp() override {
    if (labelled::data_folder().empty()) GTEST_SKIP() << "no test data: set ISIMP_DATA";
  }
};

/// Cleaning gives a mesh that its own constructor accepts, keeps all faces in their place, and changes nothing when
/// called again (except where edges of three or more faces were).
TEST_F(CleanData, EveryFileBecomesASoundMesh) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(labelled::data_folder())))
    if (const auto e = entry.path().extension(); (e == ".ply" || e == ".obj") && entry.file_size() <= kLargestFile)
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  ASSERT_GT(files.size(), 30);
  for (const fs::path& path : files) {
    SCOPED_TRACE(path.filename().string());
    const Read input = read(path);
    if (input.filled.triangles.empty()) continue;  // known/empty.ply
    const Mesh mesh = cleaned(input);
    const auto count = repairs(mesh);
    const auto get = [&](const char* key) { return count.contains(key) ? count.at(key) : 0; };
    const std::int64_t dropped = get("non_finite_faces") + get("repeated_index_faces") + get("duplicate_faces");
    const std::int64_t kept = static_cast<std::int64_t>(input.filled.triangles.size()) - dropped;
    EXPECT_GE(mesh.face_count(), kept + get("subdivided_edges"));  // an edge that is halved has one or two faces
    EXPECT_LE(mesh.face_count(), kept + 2 * get("subdivided_edges"));
    EXPECT_EQ(mesh.vertex_count(), static_cast<std::int64_t>(input.soup.vertices.size()) - get("unused_vertices") -
                                       get("welded_vertices") + get("split_vertices") + get("subdivided_edges"));
    for (std::int32_t v = 0; v < mesh.vertex_count(); ++v)
      if (mesh.source_vertex()[v] != kNone) {
        ASSERT_EQ(mesh.vertices()[v] + mesh.origin(), input.soup.vertices[mesh.source_vertex()[v]]);
      }
    ASSERT_TRUE(std::is_sorted(mesh.source_face().begin(), mesh.source_face().begin() + kept));

    const Mesh again = clean({mesh.vertices().begin(), mesh.vertices().end()},
                             {mesh.triangles().begin(), mesh.triangles().end()}, {}, job());
    if (!count.contains("split_edges")) {  // borders that taking edges apart made may lie together, to be welded
      EXPECT_TRUE(repairs(again).empty()) << repairs(again).begin()->first;
      EXPECT_TRUE(std::ranges::equal(again.triangles(), mesh.triangles()));
    }
  }
}

TEST_F(CleanData, TheKnownDefectsAreCounted) {
  using Counts = std::map<std::string, std::int64_t>;
  const auto repairs_of = [](const char* name) {
    return repairs(cleaned(read(fs::path(labelled::data_folder()) / name)));
  };
  EXPECT_EQ(repairs_of("known/cube20.ply"), Counts{});
  EXPECT_EQ(repairs_of("known/cube20_repeatidx.ply"), (Counts{{"repeated_index_faces", 100}}));
  EXPECT_EQ(repairs_of("known/cube20_zeroarea.ply"), (Counts{{"turned_edges", 130}}));
  EXPECT_EQ(repairs_of("scan/bunny_69k.ply"), (Counts{{"unused_vertices", 1113}}));
  // Its 151 parts and 257 holes are one closed surface whose blocks were never joined.
  const Mesh dragon = cleaned(read(fs::path(labelled::data_folder()) / "scan/dragon_871k.ply"));
  EXPECT_EQ(repairs(dragon), (Counts{{"turned_edges", 740}, {"welded_vertices", 2046}}));
  EXPECT_EQ(dragon.component_count(), 1);
  EXPECT_EQ(dragon.report().euler, 2 - 2 * 55);
  EXPECT_TRUE(dragon.report().closed);
  const Mesh fin = cleaned(read(fs::path(labelled::data_folder()) / "known/nm_fin_cube.ply"));
  EXPECT_EQ(repairs(fin), (Counts{{"split_edges", 10}, {"split_vertices", 11}}));
  EXPECT_EQ(fin.report().components, 2);
  EXPECT_EQ(fin.report().closed_components, 1);
  const Mesh zero = cleaned(read(fs::path(labelled::data_folder()) / "known/cube20_zeroarea.ply"));
  EXPECT_TRUE(zero.report().closed);
  EXPECT_EQ(zero.report().zero_area_faces, 0);  // there were 104
}

/// The dragon has 54 handles, of which one can't be closed at its shortest loop, where a patch would meet the surface.
TEST_F(CleanData, WhereOneLoopOfAHandleCantBeClosedAnotherIs) {
  const Read input = read(fs::path(labelled::data_folder()) / "scan/dragon_871k.ply");
  std::vector<std::int64_t> euler;
  for (const int threads : kThreads) {
    const CleanOptions options{.cut_handles = 3.5, .threads = threads};
    euler.push_back(clean(input.soup.vertices, input.filled.triangles, options, job()).report().euler);
  }
  EXPECT_GE(euler.front(), 0);
  EXPECT_EQ(euler.front(), euler.back()) << "one thread and two";
}

TEST_F(CleanData, AnEmptyFileHasNoFaces) {
  const Read input = read(fs::path(labelled::data_folder()) / "known/empty.ply");
  EXPECT_EQ(input.soup.polygon_count(), 0);
  EXPECT_THROW(cleaned(input), InvalidInput);
}

}  // namespace
}  // namespace isimp
