#include "cases.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <utility>

#include "evaluate.h"
#include "isimp/core/errors.h"
#include "isimp/interact/interact.h"
#include "isimp/mesh/clean.h"
#include "isimp/mesh/io.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/simplify/openings.h"
#include "isimp/simplify/partitioner.h"

namespace isimp::bench {
namespace {

using SetupPtr = std::shared_ptr<const Setup>;

constexpr std::size_t kScored = 20;  // number of edits that are judged: judging takes longer than editing

PartitionOptions options_of(const Setup& setup, int round, Method method, std::int32_t threads) {
  PartitionOptions options;
  options.proxies = setup.proxies;
  options.seed = static_cast<std::uint64_t>(round);
  options.method = method;
  options.threads = threads;
  return options;
}

Sample sample_of(const Setup& setup, const Lap& lap, const Partition& result) {
  Sample sample{{lap}, to_json(evaluate(*setup.mesh, setup.surface, result.face_region))};
  sample.facts["rounds"] = result.history.size();
  return sample;
}

/// From a file to triangle arrays; not for made meshes.
Case read_case(const SetupPtr& setup) {
  const auto run = [setup](int) {
    Arrays arrays;
    return Sample{{timed([&] { arrays = load_input(setup->file, 0); })}, {}};
  };
  return {"read", run, setup->inner};
}

/// Something that makes a Mesh of the arrays; they are copied before the stopwatch starts.
template <class Make>
Case mesh_case(const SetupPtr& setup, const std::string& name, Make make) {
  const auto run = [setup, make](int) {
    Arrays copy = setup->arrays;
    std::optional<Mesh> mesh;
    Job job;
    return Sample{{timed([&] { mesh.emplace(make(std::move(copy), job)); })}, {}};
  };
  return {name, run, setup->inner};
}

Case reference_case(const SetupPtr& setup) {
  const auto run = [setup](int round) {
    ReferenceResult result;
    const ReferenceOptions options{.proxies = setup->proxies, .seed = static_cast<std::uint32_t>(round)};
    const Lap lap = timed([&] { result = reference(setup->surface, options); });
    Sample sample{{lap}, to_json(evaluate(*setup->mesh, setup->surface, result.label))};
    sample.facts["round_ms"] = result.round_ms;
    return sample;
  };
  return {"reference", run, 1};
}

Case partition_case(const SetupPtr& setup, const std::string& name, Method method, std::int32_t threads) {
  const auto run = [setup, method, threads](int round) {
    Partition result;
    Job job;
    const Lap lap = timed([&] { result = partition(*setup->mesh, options_of(*setup, round, method, threads), job); });
    return sample_of(*setup, lap, result);
  };
  return {name, run, setup->inner};
}

/// Another number of regions from a warm Partitioner: a moved slider.
Case kept_case(const SetupPtr& setup, const std::string& name, const PartitionOptions& first,
               const std::function<PartitionOptions(int)>& next) {
  const auto partitioner = std::make_shared<Partitioner>(*setup->mesh);
  const auto warm = std::make_shared<bool>(false);
  const auto run = [=](int round) {
    Job job;
    if (!std::exchange(*warm, true)) (void)partitioner->run(first, {}, job);
    const PartitionOptions options = next(round);
    Partition result;
    const Lap lap = timed([&] { result = partitioner->run(options, {}, job); });
    return sample_of(*setup, lap, result);
  };
  return {name, run, setup->inner};
}

/// A smaller number. (A larger one may need smaller patches, and then pays for them once.)
Case new_count_case(const SetupPtr& setup, const std::string& name, std::int32_t threads) {
  const auto next = [setup, threads](int round) {
    PartitionOptions options = options_of(*setup, round, Method::hierarchy, threads);
    options.proxies = std::max(setup->proxies - setup->proxies / 5 - round, 1);
    return options;
  };
  return kept_case(setup, name, options_of(*setup, 0, Method::hierarchy, threads), next);
}

/// Another detail, as by the slider of the panel.
Case new_detail_case(const SetupPtr& setup, const std::string& name, double detail, double adaptivity,
                     std::int32_t threads) {
  const auto next = [=](int round) {
    PartitionOptions options = options_of(*setup, round, Method::hierarchy, threads);
    options.proxies = std::nullopt;
    options.detail = detail * (1 + 0.01 * round);
    options.adaptivity = adaptivity;
    return options;
  };
  return kept_case(setup, name, next(0), next);
}

/// Few regions within a share of the diagonal of their planes.
Case bound_case(const SetupPtr& setup, const std::string& name, double share) {
  const auto run = [setup, share](int round) {
    PartitionOptions options = options_of(*setup, round, Method::hierarchy, 1);
    options.proxies = std::nullopt;
    options.bound = share * setup->mesh->report().diagonal;
    options.noise = 0.0;
    Partition result;
    Job job;
    const Lap lap = timed([&] { result = partition(*setup->mesh, options, job); });
    return sample_of(*setup, lap, result);
  };
  return {name, run, 1};
}

/// A converged partition to edit and to make polygons of, made at its first use.
class Base {
 public:
  explicit Base(SetupPtr setup) : setup_(std::move(setup)) {}
  const Partition& get() {
    if (!partition_) {
      Job job;
      partition_ = partition(*setup_->mesh, options_of(*setup_, 1, PartitionOptions{}.method, 1), job);
    }
    return *partition_;
  }

 private:
  SetupPtr setup_;
  std::optional<Partition> partition_;
};

using Edit = Partition (*)(const Mesh&, const Partition&, std::int32_t, Job&);

/// Tries an edit at random faces, each time on the same partition, and compares its error with that of a full run for
/// as many regions.
Case edit_case(const SetupPtr& setup, const std::shared_ptr<Base>& base, const std::string& name, Edit edit) {
  const auto run = [setup, base, edit](int round) {
    const Partition& start = base->get();
    std::mt19937 random(static_cast<std::uint32_t>(round));
    Sample sample;
    Partition last;
    std::vector<double> errors;
    std::int64_t refused = 0;
    for (std::int32_t i = 0; i < setup->edits; ++i) {
      const auto face = static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(setup->mesh->face_count()));
      try {
        Job job;
        Partition result;
        sample.laps.push_back(timed([&] { result = edit(*setup->mesh, start, face, job); }));
        if (errors.size() < kScored) errors.push_back(evaluate(*setup->mesh, setup->surface, result.face_region).error);
        last = std::move(result);
      } catch (const InvalidInput&) {
        ++refused;  // a region of one face, or the last one of its part
      }
    }
    sample.facts["refused"] = refused;
    if (errors.empty()) return sample;
    PartitionOptions again = options_of(*setup, round, PartitionOptions{}.method, 1);
    again.proxies = last.region_count();
    Job job;
    const Partition full = partition(*setup->mesh, again, job);
    sample.facts["errors"] = errors;
    sample.facts["error_before"] = evaluate(*setup->mesh, setup->surface, start.face_region).error;
    sample.facts["error_of_full_run"] = evaluate(*setup->mesh, setup->surface, full.face_region).error;
    return sample;
  };
  return {name, run, 1};
}

Case polygonize_case(const SetupPtr& setup, const std::shared_ptr<Base>& base, const std::string& name,
                     const MeshingOptions& options) {
  const auto run = [setup, base, options](int) {
    const Partition& regions = base->get();
    PolygonMesh polygons;
    Job job;
    Sample sample{{timed([&] { polygons = polygonize(*setup->mesh, regions, options, job); })}, {}};
    const MeshingReport& report = polygons.report;
    sample.facts["polygons"] = report.polygons;
    sample.facts["regions"] = report.regions;
    sample.facts["corners"] = report.corners;
    sample.facts["closed"] = report.closed;
    sample.facts["manifold"] = report.manifold;
    sample.facts["planarity_max"] = report.planarity_max;
    sample.facts["intersecting"] = report.intersecting;
    sample.facts["imperfect"] = report.crossing + report.flipped + report.bent + report.intersecting;
    sample.facts["work"] = report.work.faces + report.work.corners + report.work.polygons;
    sample.facts["fingerprint"] = std::to_string(fingerprint(polygons));
    return sample;
  };
  return {name, run, 1};
}

Case write_case(const SetupPtr& setup, const std::shared_ptr<Base>& base) {
  const auto run = [setup, base](int) {
    Job job;
    const PolygonMesh polygons = polygonize(*setup->mesh, base->get(), {}, job);
    const std::string path = setup->scratch + "/polygons.ply";
    return Sample{{timed([&] { write_polygons(path, polygons.vertices, polygons.loops, polygons.loop_start, job); })},
                  {}};
  };
  return {"write", run, 1};
}

}  // namespace

std::vector<Case> all_cases(const SetupPtr& setup) {
  const auto base = std::make_shared<Base>(setup);
  const Method best = PartitionOptions{}.method;
  std::vector<Case> cases;
  if (!setup->file.empty()) cases.push_back(read_case(setup));
  cases.push_back(mesh_case(
      setup, "mesh", [](Arrays a, Job& job) { return Mesh(std::move(a.vertices), std::move(a.triangles), job); }));
  cases.push_back(mesh_case(setup, "clean", [](Arrays a, Job& job) {
    return clean(std::move(a.vertices), std::move(a.triangles), {}, job);
  }));
  cases.push_back(mesh_case(setup, "close", [setup](Arrays a, Job& job) {
    const OpeningLengths lengths = opening_lengths(*setup->mesh, setup->proxies, job);
    const CleanOptions options{
        .fill_holes = lengths.holes, .fill_flat_holes = lengths.flat_holes, .cut_handles = lengths.handles};
    return clean(std::move(a.vertices), std::move(a.triangles), options, job);
  }));
  cases.push_back(reference_case(setup));
  cases.push_back(partition_case(setup, "lloyd", Method::lloyd, 1));
  cases.push_back(partition_case(setup, "default", best, 1));
  cases.push_back(partition_case(setup, "default_two_threads", best, 2));
  cases.push_back(partition_case(setup, "teleport", Method::teleport, 1));
  cases.back().inner = 1;
  cases.push_back(new_count_case(setup, "new_count", 1));
  cases.push_back(new_count_case(setup, "new_count_two_threads", 2));
  cases.push_back(new_detail_case(setup, "new_detail", kDefaultDetail, 0, 1));
  cases.push_back(new_detail_case(setup, "new_detail_two_threads", kDefaultDetail, 0, 2));
  cases.push_back(new_detail_case(setup, "new_detail_finest", kFinestDetail, 0, 1));
  cases.push_back(new_detail_case(setup, "new_detail_adapted", kDefaultDetail, 0.25, 1));
  cases.push_back(bound_case(setup, "bound_fine", 0.0025));
  cases.push_back(bound_case(setup, "bound_mid", 0.005));
  cases.push_back(bound_case(setup, "bound_coarse", 0.01));
  cases.push_back(edit_case(setup, base, "add", add_proxy));
  cases.push_back(edit_case(setup, base, "delete", delete_proxy));
  cases.push_back(polygonize_case(setup, base, "polygonize", {.threads = 1}));
  cases.push_back(polygonize_case(setup, base, "polygonize_two_threads", {.threads = 2}));
  cases.push_back(polygonize_case(setup, base, "polygonize_planar", {.planar = true, .threads = 1}));
  cases.push_back(write_case(setup, base));
  return cases;
}

}  // namespace isimp::bench
