// Times the engine's phases on one mesh, all from one process and interleaved, so that their ratios can be trusted on
// a machine that others use too. Prints JSON; run.py makes tables and plots of it.
#include <algorithm>
#include <iostream>
#include <map>
#include <sstream>
#include <string>

#include "cases.h"
#include "isimp/core/errors.h"

namespace isimp::bench {
namespace {

const char* const kUsage =
    "isimp_bench INPUT [--proxies P] [--rounds N] [--inner N] [--edits N] [--loop N] [--cases A,B] [--scratch DIR]\n"
    "            [--whole-way]\n"
    "  INPUT        a mesh file, or made:KIND:FACES with KIND torus, slivers, plane, boxes, plate, "
    "perforated, sheet, sponge, soup\n"
    "  --proxies    how many regions (500)\n"
    "  --rounds     how often all cases are run in turn, with another seed each time (3)\n"
    "  --inner      how often a short case is run in each round (3)\n"
    "  --edits      how many faces add and delete are tried at (200)\n"
    "  --loop       steps of Loop subdivision, each four times as many faces (0)\n"
    "  --cases      only those whose names begin so, in place of all\n"
    "  --scratch    a folder for the files that are written and read (.)\n"
    "  --whole-way  in place of cases: one pass from file to file with the peak memory of each phase\n";

std::map<std::string, std::string> parse(int argc, char** argv) {
  std::map<std::string, std::string> options{{"--proxies", "500"}, {"--rounds", "3"}, {"--inner", "3"},
                                             {"--edits", "200"},   {"--loop", "0"},   {"--cases", ""},
                                             {"--scratch", "."},   {"input", ""}};
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (!word.starts_with("--")) {
      options["input"] = word;
    } else if (word == "--whole-way") {
      options[word] = "";
    } else if (options.contains(word) && i + 1 < argc) {
      options[word] = argv[++i];
    } else {
      throw InvalidInput("unknown option, or one without its value: " + word + "\n" + kUsage);
    }
  }
  if (options["input"].empty()) throw InvalidInput(kUsage);
  return options;
}

bool wanted(const std::string& name, const std::string& list) {
  if (list.empty()) return true;
  std::istringstream words(list);
  for (std::string word; std::getline(words, word, ',');)
    if (name.starts_with(word)) return true;
  return false;
}

Json describe(const Setup& setup) {
  const MeshReport& report = setup.mesh->report();
  Json json;
  json["faces"] = report.faces;
  json["vertices"] = report.vertices;
  json["components"] = report.components;
  json["border_loops"] = report.border_loops;
  json["area"] = report.area;
  json["diagonal"] = report.diagonal;
  return json;
}

Json run_cases(const std::shared_ptr<const Setup>& setup, const std::string& list, int rounds) {
  std::vector<Case> cases = all_cases(setup);
  std::erase_if(cases, [&](const Case& c) { return !wanted(c.name, list); });
  std::map<std::string, std::vector<Json::List>> samples;  // by case and round
  for (int round = 1; round <= rounds; ++round)
    for (const Case& c : cases) {
      Json::List of_round;
      for (int i = 0; i < c.inner; ++i) {
        Sample sample = c.run(round);
        Json::List cpu, own, wall;
        for (const Lap& lap : sample.laps) {
          cpu.emplace_back(lap.cpu_ms);
          own.emplace_back(lap.own_ms);
          wall.emplace_back(lap.wall_ms);
        }
        sample.facts["cpu_ms"] = cpu;
        sample.facts["own_ms"] = own;
        sample.facts["wall_ms"] = wall;
        of_round.push_back(std::move(sample.facts));
      }
      samples[c.name].push_back(std::move(of_round));
    }
  Json json;
  for (auto& [name, by_round] : samples) json[name] = Json::List(by_round.begin(), by_round.end());
  return json;
}

int run(int argc, char** argv) {
  auto options = parse(argc, argv);
  const std::string input = options["input"];
  const auto number = [&](const char* name) { return static_cast<std::int32_t>(std::stol(options[name])); };
  Json json;
  json["input"] = input;
  json["loop"] = number("--loop");
  json["proxies"] = number("--proxies");
  if (options.contains("--whole-way")) {
    json["whole_way"] = whole_way(input, number("--loop"), number("--proxies"), options["--scratch"]);
  } else {
    const auto setup = std::make_shared<Setup>();
    if (!input.starts_with("made:")) setup->file = input;
    setup->scratch = options["--scratch"];
    setup->arrays = load_input(input, number("--loop"));
    Job job;
    setup->mesh = std::make_shared<const Mesh>(setup->arrays.vertices, setup->arrays.triangles, job);
    setup->surface = plain_surface(*setup->mesh);
    setup->proxies = std::min(number("--proxies"), setup->mesh->face_count());
    setup->edits = number("--edits");
    setup->inner = number("--inner");
    json["mesh"] = describe(*setup);
    json["cases"] = run_cases(setup, options["--cases"], number("--rounds"));
  }
  std::cout << json << '\n';
  return 0;
}

}  // namespace
}  // namespace isimp::bench

int main(int argc, char** argv) {
  try {
    return isimp::bench::run(argc, argv);
  } catch (const isimp::InvalidInput& error) {
    std::cerr << error.what() << '\n';
    return 2;
  } catch (const std::logic_error&) {  // std::stol failed
    std::cerr << "a number was expected\n" << isimp::bench::kUsage;
    return 2;
  }
}
