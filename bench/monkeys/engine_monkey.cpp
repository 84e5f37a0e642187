// Edits of every kind at many faces of scans, at eight details, each result checked (tests/cpp/shared/edit_monkey.h). Built
// with -DISIMP_SANITIZE=ON -DISIMP_ASSERTIONS=ON it also finds faults that a check of the result would miss.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "edit_monkey.h"
#include "isimp/core/errors.h"
#include "isimp/mesh/clean.h"
#include "isimp/mesh/io.h"
#include "labelled.h"

namespace isimp {
namespace {

constexpr double kDetails[] = {0.04, 0.02, 0.01, 0.007, 0.005, 0.0035, 0.0025, 0.00125};
const char* const kUsage =
    "engine_monkey [--seconds S] [--seed N] [--regions N] [--faces N] [--most FACES] [--polygons 0] [FILE...]\n"
    "  FILE       mesh files (default: all of the data folder, ISIMP_DATA)\n"
    "  --seconds  spent on each partition (20)\n"
    "  --seed     of the random numbers (1)\n"
    "  --regions  of each partition that are edited, at 4 faces each (50)\n"
    "  --faces    drawn from all faces (200)\n"
    "  --most     faces of a scan; larger scans are skipped (200000)\n"
    "  --polygons 0: skip the meshing, which takes most of the time (1)\n";

std::vector<std::string> files_of(const std::string& folder) {
  std::vector<std::string> files;
  if (folder.empty()) return files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (const auto e = entry.path().extension(); e == ".ply" || e == ".obj" || e == ".stl" || e == ".off")
      files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

void run_file(const std::string& file, std::int32_t most, const monkey::Settings& settings, monkey::Tally& tally) {
  const auto start = std::chrono::steady_clock::now();
  const std::int64_t before = tally.actions();
  const std::size_t found = tally.findings.size();
  try {
    Job job;
    const PolygonSoup soup = read_polygons(file, job);
    const Mesh mesh = clean(soup.vertices, triangulate(soup, job).triangles, {}, job);
    if (mesh.face_count() > most) return;
    const std::string name = std::filesystem::path(file).filename().string();
    monkey::run_all(mesh, name, {std::begin(kDetails), std::end(kDetails)}, true, settings, tally);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    std::cout << name << ": " << mesh.face_count() << " faces, " << tally.actions() - before << " edits, " << seconds
              << " s, " << tally.findings.size() - found << " findings" << std::endl;
    for (std::size_t k = found; k < tally.findings.size(); ++k) std::cout << "  " << tally.findings[k] << std::endl;
  } catch (const Error& e) {
    std::cout << file << ": " << e.what() << std::endl;
  }
}

int run(int argc, char** argv) {
  monkey::Settings settings{.seconds = 20};
  std::int32_t most = 200000;
  std::vector<std::string> files;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (!word.starts_with("--")) {
      files.push_back(word);
      continue;
    }
    if (i + 1 == argc) throw InvalidInput(word + " needs a value\n" + kUsage);
    const double value = std::stod(argv[++i]);
    if (word == "--seconds")
      settings.seconds = value;
    else if (word == "--seed")
      settings.seed = static_cast<std::uint32_t>(value);
    else if (word == "--regions")
      settings.random_regions = static_cast<int>(value);
    else if (word == "--faces")
      settings.random_faces = static_cast<int>(value);
    else if (word == "--polygons")
      settings.polygonize = value != 0;
    else if (word == "--most")
      most = static_cast<std::int32_t>(value);
    else
      throw InvalidInput("unknown option " + word + "\n" + kUsage);
  }
  if (files.empty()) files = files_of(labelled::data_folder());
  if (files.empty()) throw InvalidInput(std::string("no file is given and there is no data folder\n") + kUsage);
  monkey::Tally tally;
  for (const std::string& file : files) run_file(file, most, settings, tally);
  std::cout << monkey::report(tally);
  return tally.findings.empty() ? 0 : 1;
}

}  // namespace
}  // namespace isimp

int main(int argc, char** argv) {
  try {
    return isimp::run(argc, argv);
  } catch (const std::exception& e) {
    std::cerr << "error: " << e.what() << '\n';
    return 2;
  }
}
