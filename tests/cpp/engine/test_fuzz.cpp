#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <random>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "isimp/core/errors.h"
#include "isimp/interact/heuristics.h"
#include "isimp/interact/interact.h"
#include "isimp/interact/lock.h"
#include "isimp/interact/merge.h"
#include "isimp/interact/paint.h"
#include "isimp/interact/statistics.h"
#include "isimp/mesh/clean.h"
#include "isimp/mesh/io.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/partition/soundness.h"
#include "isimp/regular/regularise.h"
#include "isimp/simplify/partitioner.h"
#include "partition_checks.h"
#include "polygon_judge.h"
#include "tests.h"

/// Random meshes and files pass through all steps: each either is refused with a message or keeps every promise.
/// ISIMP_FUZZ_CASES is the number of cases of each kind (250), ISIMP_FUZZ_SECONDS a time to run instead,
/// ISIMP_FUZZ_FIRST the first case's number: a failure names its own, so that it can be repeated.
namespace isimp {
namespace {

using shapes::Arrays;

std::int64_t setting(const char* name, std::int64_t otherwise) {
  const char* text = std::getenv(name);
  return text ? std::atoll(text) : otherwise;
}

class Dice {
 public:
  explicit Dice(std::uint32_t seed) : random_(seed) {}
  /// In [low, high].
  std::int32_t number(std::int32_t low, std::int32_t high) {
    return low + static_cast<std::int32_t>(random_() % static_cast<std::uint32_t>(high - low + 1));
  }
  bool chance(int in) { return number(1, in) == 1; }
  double share() { return static_cast<double>(random_()) / 4294967296.0; }
  Vec3 place() { return {2 * share() - 1, 2 * share() - 1, 2 * share() - 1}; }
  std::uint32_t seed() { return random_(); }

 private:
  std::mt19937 random_;
};

/// Runs `run(dice)` for every case; the first failure ends it and is named.
void for_each_case(const std::function<void(Dice&)>& run) {
  const std::int64_t first = setting("ISIMP_FUZZ_FIRST", 0), seconds = setting("ISIMP_FUZZ_SECONDS", 0);
  const std::int64_t last =
      seconds > 0 ? std::numeric_limits<std::int64_t>::max() : first + setting("ISIMP_FUZZ_CASES", 250);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
  std::int64_t number = first;
  for (; number < last && (seconds <= 0 || std::chrono::steady_clock::now() < end); ++number) {
    const testing::ScopedTrace trace(__FILE__, __LINE__, "ISIMP_FUZZ_FIRST=" + std::to_string(number));
    Dice dice(static_cast<std::uint32_t>(number));
    run(dice);
    if (testing::Test::HasFailure()) return;
  }
  testing::Test::RecordProperty("cases", std::to_string(number - first));
}

/// Few vertices and any faces on them.
Arrays soup(Dice& dice) {
  Arrays a;
  const std::int32_t vertices = dice.number(1, 12), faces = dice.number(1, 40);
  const bool on_grid = dice.chance(2);
  for (std::int32_t v = 0; v < vertices; ++v) {
    const Vec3 p = dice.place();
    a.vertices.push_back(on_grid ? Vec3((2 * p).array().round()) : p);
  }
  for (std::int32_t f = 0; f < faces; ++f) {
    Triangle t;
    for (std::int32_t& v : t) v = dice.number(0, vertices - 1);
    a.triangles.push_back(t);
  }
  return a;
}

Arrays shape(Dice& dice) {
  switch (dice.number(0, 5)) {
    case 0:
      return shapes::cube(dice.number(1, 6));
    case 1:
      return shapes::sphere(dice.number(0, 2));
    case 2:
      return shapes::plane(dice.number(1, 8));
    case 3:
      return shapes::torus(dice.number(3, 14), dice.number(3, 10), 0.2 + 0.3 * dice.share());
    case 4:
      return shapes::both(shapes::cube(dice.number(1, 3)), shapes::sphere(1), dice.place() * 2);
    default:
      return soup(dice);
  }
}

/// A plate of cells with holes where cells are missing, in rows or anywhere; sometimes its sides are not quite flat.
Arrays plate(Dice& dice) {
  const std::int32_t w = dice.number(5, 12), h = dice.number(5, 12), one_in = dice.number(2, 6);
  const bool in_rows = dice.chance(2);
  std::vector<bool> solid(static_cast<std::size_t>(w) * h);
  for (std::int32_t i = 0; i < w * h; ++i)
    solid[i] = in_rows ? i % w % 3 != 1 || i / w % 3 != 1 || dice.chance(8) : !dice.chance(one_in);
  const double thickness = 0.1 + dice.share(), noise = dice.chance(2) ? 0 : 0.05 * dice.share();
  Arrays a = shapes::perforated(w, h, thickness, [&](int x, int y) { return !solid[y * w + x]; });
  for (Vec3& vertex : a.vertices) vertex += noise * dice.place();
  return a;
}

/// Does to a mesh one of the things that happen to meshes.
void damage(Arrays& a, Dice& dice) {
  const auto any_vertex = [&] { return dice.number(0, static_cast<std::int32_t>(a.vertices.size()) - 1); };
  const auto any_face = [&]() -> Triangle& {
    return a.triangles[dice.number(0, static_cast<std::int32_t>(a.triangles.size()) - 1)];
  };
  switch (dice.number(0, 10)) {
    case 0:  // holes
      for (int i = 0; i < 3 && a.triangles.size() > 1; ++i) {
        std::swap(any_face(), a.triangles.back());
        a.triangles.pop_back();
      }
      break;
    case 1:
      for (int i = 0; i < 3; ++i) a.triangles.push_back(any_face());
      break;
    case 2: {
      Triangle& t = any_face();
      std::swap(t[0], t[1]);
      break;
    }
    case 3: {  // two places of the surface share a vertex
      const std::int32_t from = any_vertex(), to = any_vertex();
      for (Triangle& t : a.triangles) std::replace(t.begin(), t.end(), from, to);
      break;
    }
    case 4:
      a.vertices[any_vertex()] = a.vertices[any_vertex()];
      break;
    case 5:
      a.vertices[any_vertex()] += dice.place();
      break;
    case 6:
      a.vertices[any_vertex()][dice.number(0, 2)] =
          dice.chance(2) ? std::nan("") : std::numeric_limits<double>::infinity();
      break;
    case 7:
      a.triangles.push_back({any_vertex(), any_vertex(), any_vertex()});
      break;
    case 8:
      a = shapes::noisy(a, 0.1 * dice.share(), dice.seed());
      break;
    case 9: {
      const double scale = std::pow(10.0, dice.number(-9, 9));
      const Vec3 away = dice.chance(3) ? Vec3(dice.place() * 1e4) : Vec3::Zero();
      for (Vec3& p : a.vertices) p = (p + away) * scale;
      break;
    }
    default:
      a = shapes::both(a, a, dice.chance(2) ? Vec3::Zero() : Vec3(dice.place()));
  }
}

CleanOptions clean_options(Dice& dice) {
  CleanOptions options;
  if (dice.chance(4)) options.weld = 0.2 * dice.share();
  if (dice.chance(3)) options.fill_holes = 4 * dice.share();
  if (dice.chance(3)) options.cut_handles = 4 * dice.share();
  return options;
}

PartitionOptions partition_options(Dice& dice, std::int32_t faces) {
  PartitionOptions options;
  options.proxies = std::min(faces, dice.chance(8) ? faces : dice.number(1, 30));
  options.leave_out = dice.chance(2) ? 0.0 : 0.2 * dice.share();
  options.seed = dice.seed();
  options.iterations = dice.number(1, 12);
  options.seeding = static_cast<Seeding>(dice.number(0, 2));
  options.method = static_cast<Method>(dice.number(0, static_cast<int>(Method::queued)));
  options.connect = static_cast<Connect>(dice.number(0, 1));
  options.threads = dice.number(1, 2);
  options.smooth = dice.chance(2) ? 0.5 : dice.share();
  if (dice.chance(3)) {
    options.proxies.reset();
    options.detail = 0.001 * std::pow(10.0, 2 * dice.share());
    if (dice.chance(3)) options.adaptivity = 0.25;
  }
  return options;
}

MeshingOptions meshing_options(Dice& dice) {
  MeshingOptions options;
  if (dice.chance(3)) options.chord_tolerance = 0.05 + dice.share();
  if (dice.chance(3)) options.flatten = dice.number(0, 40);
  if (dice.chance(3)) options.flatness_from = 1;
  if (dice.chance(3)) options.repair_budget = 2 * dice.share();
  return options;
}

/// The number of faces that are so thin that they count as without area: the polygons may have as many, and no more.
std::int32_t thin_faces(const Mesh& mesh) {
  constexpr double kThin = 2e-6;  // share of the diagonal; twice the engine's bound, as it measures extents otherwise
  return static_cast<std::int32_t>(std::count_if(mesh.triangles().begin(), mesh.triangles().end(), [&](auto& t) {
    const Vec3 &a = mesh.vertices()[t[0]], &b = mesh.vertices()[t[1]], &c = mesh.vertices()[t[2]];
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    return (b - a).cross(c - a).norm() <= kThin * mesh.diagonal() * longest;
  }));
}

/// The judge's defects, except polygons without area where the scan has as many faces without any, or where the budget
/// of the repair was spent and the report names them.
std::string unexcused(std::string defects, const PolygonMesh& polygons, const Mesh& mesh) {
  if (polygons.report.repair_capped)
    for (const ListedDefect& i : polygons.report.imperfect)
      if (i.kind == Defect::no_area)
        defects =
            std::regex_replace(defects, std::regex("polygon " + std::to_string(i.polygon) + " has no area; "), "");
  const std::regex no_area("polygon [0-9]+ has no area; ");
  const auto flat =
      std::distance(std::sregex_iterator(defects.begin(), defects.end(), no_area), std::sregex_iterator());
  return flat <= thin_faces(mesh) ? std::regex_replace(defects, no_area, "") : defects;
}

/// \param most_damages  that are done to the mesh first
void all_the_way(Arrays a, Dice& dice, std::int32_t most_damages) {
  for (int i = dice.number(0, most_damages); i > 0; --i) damage(a, dice);
  try {
    const Mesh mesh = clean(a.vertices, a.triangles, clean_options(dice), job());
    Partition p = partition(mesh, partition_options(dice, mesh.face_count()), job());
    checks::expect_sound_regions(mesh, p);
    for (int i = dice.number(0, 3); i > 0 && !testing::Test::HasFailure(); --i) {
      try {
        const std::int32_t face = dice.number(0, mesh.face_count() - 1);
        p = dice.chance(2) ? add_proxy(mesh, p, face, job()) : delete_proxy(mesh, p, face, job());
      } catch (const InvalidInput&) {  // the only region of its part, or one face alone
      }
      checks::expect_sound_regions(mesh, p);
    }
    if (testing::Test::HasFailure()) return;
    const PolygonMesh polygons = polygonize(mesh, p, meshing_options(dice), job());
    EXPECT_EQ(unexcused(judge::defects_against(polygons, mesh, p), polygons, mesh), "");
  } catch (const InvalidInput& e) {
    EXPECT_GT(std::string(e.what()).size(), 10U);
  }
}

TEST(Fuzz, SoupsOfFaces) {
  for_each_case([](Dice& dice) { all_the_way(soup(dice), dice, 4); });
}

/// The same far from the origin, where few bits are left for the shape: places up to 5e7 away, sizes 1e-3 to 1e3. The
/// coordinates are rounded like doubles in a file.
TEST(Fuzz, Offsets) {
  for_each_case([](Dice& dice) {
    Arrays a = dice.chance(4) ? soup(dice) : shape(dice);
    for (int i = dice.number(0, 2); i > 0; --i) damage(a, dice);
    const double size = std::pow(10.0, 6 * dice.share() - 3);
    const Vec3 away = dice.place() * std::pow(10.0, dice.share() * std::log10(5e7));
    for (Vec3& p : a.vertices) p = p * size + away;
    all_the_way(std::move(a), dice, 0);
  });
}

TEST(Fuzz, DamagedShapes) {
  for_each_case([](Dice& dice) { all_the_way(shape(dice), dice, 4); });
}

TEST(Fuzz, Plates) {
  for_each_case([](Dice& dice) { all_the_way(plate(dice), dice, 2); });
}

/// An edit at a face: of its region and another one's, and of some faces around it.
struct Act {
  const Mesh& mesh;
  const Partition& before;
  std::int32_t face, other;
  std::vector<std::int32_t> faces;
  Vec3 by;
  std::int32_t few;
  Job& job;
};

const std::map<std::string, Partition (*)(const Act&)> kEdits{
    {"add", [](const Act& a) { return add_proxy(a.mesh, a.before, a.face, a.job); }},
    {"delete", [](const Act& a) { return delete_proxy(a.mesh, a.before, a.face, a.job); }},
    {"split", [](const Act& a) { return split_region(a.mesh, a.before, a.face, a.job); }},
    {"cut",
     [](const Act& a) {
       const Vec3 at = a.mesh.vertices()[a.mesh.triangles()[a.face][0]] + a.mesh.origin();
       return split_along(a.mesh, a.before, a.face, std::vector<Vec3>{at - a.by, at + a.by}, Vec3::Zero(), a.job);
     }},
    {"merge", [](const Act& a) { return merge_regions(a.mesh, a.before, a.face, a.other, a.job); }},
    {"paint", [](const Act& a) { return paint_faces(a.mesh, a.before, a.faces, kNone, a.job); }},
    {"paint onto", [](const Act& a) { return paint_faces(a.mesh, a.before, a.faces, a.other, a.job); }},
    {"erase", [](const Act& a) { return erase_faces(a.mesh, a.before, a.faces, a.job); }},
    {"grow", [](const Act& a) { return grow_region(a.mesh, a.before, a.face, a.few, a.job); }},
    {"shrink", [](const Act& a) { return shrink_region(a.mesh, a.before, a.face, a.few, a.job); }},
    {"lock", [](const Act& a) { return set_locked(a.mesh, a.before, std::vector{a.face}, kLocked); }},
    {"leave out", [](const Act& a) { return set_locked(a.mesh, a.before, std::vector{a.face}, kLeftOut); }},
    {"unlock", [](const Act& a) { return set_locked(a.mesh, a.before, a.faces, 0); }},
    {"worst", [](const Act& a) { return add_worst(a.mesh, a.before, a.few, a.job); }},
    {"least", [](const Act& a) { return delete_least(a.mesh, a.before, a.few, a.job); }},
    {"cheapest", [](const Act& a) { return merge_cheapest(a.mesh, a.before, a.few, a.job); }},
    {"improve", [](const Act& a) { return improve(a.mesh, a.before, a.job); }},
    {"even", [](const Act& a) { return even_borders(a.mesh, a.before, 0.5, a.job); }},
    {"regularise", [](const Act& a) { return regularise(a.mesh, a.before, {}, a.job); }},
};

/// Edits, each on the result of the one before or on the first partition, which may have guides.
void edit_at_random(const Mesh& mesh, Dice& dice, std::map<std::string, int>& done) {
  const auto face = [&] { return dice.number(0, mesh.face_count() - 1); };
  Constraints constraints;
  std::vector<VertexPair> edges;
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); h += 7) edges.push_back({mesh.from(h), mesh.to(h)});
  std::vector<double> weights(static_cast<std::size_t>(mesh.face_count()), 1);
  for (std::size_t f = 0; f < weights.size(); f += 3) weights[f] = f % 2 == 0 ? 0 : 50;
  if (dice.chance(6)) constraints.guides.barriers = edges;
  if (dice.chance(6)) constraints.cuts = edges;
  if (dice.chance(6)) constraints.guides.weights = weights;
  PartitionOptions options = partition_options(dice, mesh.face_count());
  if (dice.chance(6)) options = {.bound = 0.02 * mesh.diagonal()};
  Job job;
  const Partition first = Partitioner(mesh).run(options, constraints, job);
  Partition now = first;
  for (int k = 0; k < 30; ++k) {
    if (dice.chance(8)) now = first;
    const auto& [name, edit] = *std::next(kEdits.begin(), dice.number(0, static_cast<std::int32_t>(kEdits.size()) - 1));
    std::vector<std::int32_t> faces{face()};
    for (int more = dice.number(0, 8); more > 0; --more)
      if (const std::int32_t o = mesh.opposite(3 * faces.back() + dice.number(0, 2)); o != kNone)
        faces.push_back(o / 3);
    const Vec3 by = 0.1 * mesh.diagonal() * dice.place();
    try {
      Partition after = edit({mesh, now, faces[0], face(), faces, by, dice.number(1, 3), job});
      (void)all_statistics(mesh, after, job);
      ASSERT_EQ(broken_promise(Surface(mesh, after.guided), after), "") << name << " at " << faces[0];
      ++done[name];
      now = std::move(after);
    } catch (const InvalidInput&) {
      continue;
    }
  }
  const PolygonMesh polygons = polygonize(mesh, now, {}, job);
  if (polygons.report.without_area == 0 && !polygons.report.repair_capped) {
    EXPECT_EQ(judge::defects_against(polygons, mesh, now), "");
  }
}

/// bench/monkeys/monkey.py judges the changes of each edit; this test sees the sums of regions, and runs with sanitizers
/// and assertions too.
TEST(Fuzz, ChainsOfEdits) {
  std::map<std::string, int> done;
  for_each_case([&](Dice& dice) {
    const Arrays a = shapes::noisy(shape(dice), 0.1 * dice.share(), dice.seed());
    Job job;
    try {
      edit_at_random(clean(a.vertices, a.triangles, {}, job), dice, done);
    } catch (const InvalidInput& e) {
      EXPECT_GT(std::string(e.what()).size(), 10U);
    }
  });
  EXPECT_TRUE(testing::Test::HasFailure() || done.size() == kEdits.size()) << "an edit was never done";
}

/// A file of one of the formats, as text or bytes.
std::string written(const std::string& extension, const Arrays& a, const std::filesystem::path& folder) {
  std::ostringstream text;
  if (extension == ".off") {
    text << "OFF\n" << a.vertices.size() << ' ' << a.triangles.size() << " 0\n";
    for (const Vec3& p : a.vertices) text << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
    for (const auto& [i, j, k] : a.triangles) text << "3 " << i << ' ' << j << ' ' << k << '\n';
    return text.str();
  }
  if (extension == ".stl") {
    text << "solid s\n";
    for (const Triangle& t : a.triangles) {
      text << "facet normal 0 0 0\nouter loop\n";
      for (const std::int32_t v : t)
        text << "vertex " << a.vertices[v].x() << ' ' << a.vertices[v].y() << ' ' << a.vertices[v].z() << '\n';
      text << "endloop\nendfacet\n";
    }
    text << "endsolid s\n";
    return text.str();
  }
  std::vector<std::int32_t> loops, starts;
  for (const Triangle& t : a.triangles) {
    starts.push_back(static_cast<std::int32_t>(loops.size()));
    loops.insert(loops.end(), t.begin(), t.end());
  }
  write_polygons(folder / ("good" + extension), a.vertices, loops, starts, job());
  std::ifstream file(folder / ("good" + extension), std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void damage(std::string& bytes, Dice& dice) {
  const auto any = [&] {
    return static_cast<std::size_t>(dice.number(0, static_cast<std::int32_t>(bytes.size()) - 1));
  };
  if (bytes.empty()) return;
  switch (dice.number(0, 6)) {
    case 0:
      bytes.resize(any());
      break;
    case 1:
      bytes[any()] = static_cast<char>(dice.number(0, 255));
      break;
    case 2:
      bytes.erase(any(), static_cast<std::size_t>(dice.number(1, 20)));
      break;
    case 3:
      bytes.insert(any(),
                   std::string(static_cast<std::size_t>(dice.number(1, 20)), static_cast<char>(dice.number(0, 255))));
      break;
    case 4: {  // a number becomes another
      const auto digit = bytes.find_first_of("0123456789", any());
      const char* const numbers[] = {"-1", "99999999999999999999", "4294967295", "nan", "1e999", "0", "2147483647"};
      if (digit != std::string::npos) bytes.replace(digit, 1, numbers[dice.number(0, 6)]);
      break;
    }
    case 5: {
      const std::size_t from = any();
      bytes.insert(any(), bytes.substr(from, static_cast<std::size_t>(dice.number(1, 60))));
      break;
    }
    default:  // in the header, which describes the data
      bytes[any() % std::min<std::size_t>(bytes.size(), 200)] = static_cast<char>(dice.number(32, 126));
  }
}

TEST(Fuzz, BytesOfFiles) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("isimp_fuzz_" + std::to_string(std::random_device()()));
  std::filesystem::create_directories(folder);
  for_each_case([&](Dice& dice) {
    const char* const extensions[] = {".ply", ".obj", ".stl", ".off"};
    const std::string extension = extensions[dice.number(0, 3)];
    std::string bytes = written(extension, dice.chance(2) ? shapes::cube(dice.number(1, 2)) : soup(dice), folder);
    for (int i = dice.number(1, 4); i > 0; --i) damage(bytes, dice);
    const std::filesystem::path path = folder / ("damaged" + extension);
    std::ofstream(path, std::ios::binary) << bytes;
    try {
      const PolygonSoup polygons = read_polygons(path, job());
      for (const std::int32_t v : polygons.loops) {
        ASSERT_GE(v, 0);
        ASSERT_LT(v, static_cast<std::int32_t>(polygons.vertices.size()));
      }
      const Triangulation cut = triangulate(polygons, job());
      if (!cut.triangles.empty()) static_cast<void>(clean(polygons.vertices, cut.triangles, {}, job()));
    } catch (const FileError& e) {
      EXPECT_NE(std::string(e.what()).find("damaged"), std::string::npos) << e.what();
    } catch (const InvalidInput& e) {
      EXPECT_GT(std::string(e.what()).size(), 10U);
    }
  });
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace isimp
