#include "edit_monkey.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <sstream>

#include "isimp/core/errors.h"
#include "isimp/interact/heuristics.h"
#include "isimp/interact/interact.h"
#include "isimp/interact/lock.h"
#include "isimp/interact/merge.h"
#include "isimp/interact/paint.h"
#include "isimp/interact/statistics.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/partition/soundness.h"
#include "isimp/regular/regularise.h"
#include "isimp/simplify/partitioner.h"
#include "polygon_judge.h"

namespace isimp::monkey {
namespace {

using Labels = std::vector<std::int32_t>;
using Random = std::mt19937;

std::int32_t below(Random& random, std::size_t n) { return static_cast<std::int32_t>(random() % n); }

Vec3 any_vector(Random& random) {
  const auto share = [&] { return static_cast<double>(random()) / 2147483648.0 - 1; };
  const double x = share(), y = share();
  return {x, y, share()};
}

/// One edit with its input and its result.
struct Act {
  const Mesh& mesh;
  const Partition& before;
  std::int32_t face;
  Random& random;
  Job& job;
  std::int32_t region = before.face_region[face];  ///< region of the face
  std::vector<std::int32_t> faces = {};            ///< more faces that were given
  std::int32_t other = kNone;                      ///< a face of another region

  [[nodiscard]] bool locked(std::int32_t r) const {
    return r != kNone && !before.region_locked.empty() && before.region_locked[r] != 0;
  }
};

/// A face across an edge of the region of a face; kNone where no other region is adjacent to it.
std::int32_t face_beside(const Mesh& mesh, const Labels& label, std::int32_t region, Random& random) {
  std::vector<std::int32_t> beside;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (label[f] != region) continue;
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h)
      if (const std::int32_t o = mesh.opposite(h); o != kNone && label[o / 3] != region && label[o / 3] != kNone)
        beside.push_back(o / 3);
  }
  return beside.empty() ? kNone : beside[below(random, beside.size())];
}

/// A face and its neighbours, in up to three rings.
std::vector<std::int32_t> blot(const Mesh& mesh, std::int32_t face, Random& random) {
  std::vector<std::int32_t> faces{face};
  std::vector<bool> seen(static_cast<std::size_t>(mesh.face_count()), false);
  seen[face] = true;
  const std::size_t most = 1 + random() % 12;
  for (std::size_t k = 0; k < faces.size() && faces.size() < most; ++k)
    for (std::int32_t h = 3 * faces[k]; h < 3 * faces[k] + 3; ++h)
      if (const std::int32_t o = mesh.opposite(h); o != kNone && !seen[o / 3]) {
        seen[o / 3] = true;
        faces.push_back(o / 3);
      }
  return faces;
}

Vec3 middle_of(const Mesh& mesh, std::int32_t f) {
  const Triangle& t = mesh.triangles()[f];
  return (mesh.vertices()[t[0]] + mesh.vertices()[t[1]] + mesh.vertices()[t[2]]) / 3 + mesh.origin();
}

/// A forbidden effect of an edit; empty if there is none. Regions are compared by the numbers in `before`.
/// \param gone  a region whose number was removed, so that the numbers above it decreased by one
std::string changed_only(const Act& act, const Partition& after, std::int32_t gone,
                         const std::function<bool(std::int32_t from, std::int32_t to)>& may) {
  for (std::size_t f = 0; f < after.face_region.size(); ++f) {
    const std::int32_t from = act.before.face_region[f];
    std::int32_t to = after.face_region[f];
    if (gone != kNone && to >= gone) ++to;
    if (from != to && !may(from, to))
      return "face " + std::to_string(f) + " went from region " + std::to_string(from) + " to " + std::to_string(to);
  }
  return "";
}

std::string count_is(const Partition& after, std::int32_t count) {
  if (after.region_count() == count) return "";
  return "there are " + std::to_string(after.region_count()) + " regions, not " + std::to_string(count);
}

/// The painted faces may include all faces of some regions: each of these loses its number.
std::string locked_stay(const Act& act, const Partition& after) {
  std::vector<std::int32_t> becomes(act.before.region_seed.size(), kNone);
  for (std::size_t f = 0; f < after.face_region.size(); ++f) {
    const std::int32_t from = act.before.face_region[f], to = after.face_region[f];
    if (!act.locked(from)) continue;
    if (becomes[from] == kNone) becomes[from] = to;
    if (becomes[from] != to) return "a locked region has lost face " + std::to_string(f);
    if (after.region_locked.empty() || after.region_locked[to] == 0)
      return "locked region " + std::to_string(from) + " is not locked any more";
    if (act.before.region_sum[from].faces != after.region_sum[to].faces)
      return "a locked region has another number of faces";
  }
  return "";
}

struct Edit {
  const char* name;
  std::function<Partition(Act&)> run;
  std::function<std::string(const Act&, const Partition& after)> check;
  bool keeps_locked = true;  ///< false if the edit may change a locked region
};

std::string grew_by_one(const Act& act, const Partition& after) {
  return count_is(after, act.before.region_count() + 1);
}
std::string shrank_by_one(const Act& act, const Partition& after) {
  return count_is(after, act.before.region_count() - 1);
}
std::string split_off(const Act& act, const Partition& after) {
  const std::int32_t fresh = act.before.region_count();
  if (std::string wrong = grew_by_one(act, after); !wrong.empty()) return wrong;
  if (after.face_region[act.face] != act.region) return "the face is not in its region any more";
  return changed_only(act, after, kNone, [&](auto from, auto to) { return from == act.region && to == fresh; });
}

std::vector<Edit> single_edits() {
  return {
      {"add_proxy", [](Act& a) { return add_proxy(a.mesh, a.before, a.face, a.job); },
       [](const Act& a, const Partition& after) {
         if (std::string wrong = grew_by_one(a, after); !wrong.empty()) return wrong;
         const bool is_new = after.face_region[a.face] == a.before.region_count();
         return std::string(is_new ? "" : "the face is not in the new region");
       }},
      {"delete_proxy", [](Act& a) { return delete_proxy(a.mesh, a.before, a.face, a.job); }, shrank_by_one},
      {"split_region", [](Act& a) { return split_region(a.mesh, a.before, a.face, a.job); }, split_off},
      {"split_along",
       [](Act& a) {
         const Vec3 at = middle_of(a.mesh, a.face), by = a.mesh.diagonal() * 0.05 * any_vector(a.random);
         const std::vector<Vec3> line{at - by, at + 0.1 * by.norm() * any_vector(a.random), at + by};
         const Vec3 along = a.random() % 2 == 0 ? Vec3::Zero() : any_vector(a.random);
         return split_along(a.mesh, a.before, a.face, line, along, a.job);
       },
       split_off},
      {"merge",
       [](Act& a) {
         a.other = a.region == kNone ? a.face : face_beside(a.mesh, a.before.face_region, a.region, a.random);
         return merge_regions(a.mesh, a.before, a.face, a.other, a.job);
       },
       [](const Act& a, const Partition& after) {
         const std::int32_t gone = a.before.face_region[a.other];
         if (std::string wrong = shrank_by_one(a, after); !wrong.empty()) return wrong;
         return changed_only(a, after, gone, [&](auto from, auto to) { return from == gone && to == a.region; });
       }},
  };
}

std::vector<Edit> brush_edits() {
  return {
      {"paint",
       [](Act& a) {
         a.faces = blot(a.mesh, a.face, a.random);
         return paint_faces(a.mesh, a.before, a.faces, kNone, a.job);
       },
       [](const Act& a, const Partition& after) {
         const std::int32_t fresh = after.face_region[a.face];
         for (const std::int32_t f : a.faces)
           if (!a.locked(a.before.face_region[f]) && !a.locked(a.region) && after.face_region[f] != fresh)
             return "painted face " + std::to_string(f) + " is in another region";
         return std::string();
       }},
      {"paint onto",
       [](Act& a) {
         a.faces = blot(a.mesh, a.face, a.random);
         a.other = a.region == kNone ? a.face : face_beside(a.mesh, a.before.face_region, a.region, a.random);
         return paint_faces(a.mesh, a.before, a.faces, a.other, a.job);
       },
       [](const Act& a, const Partition& after) {
         return a.other != kNone && after.region_count() > a.before.region_count()
                    ? std::string("there are more regions")
                    : std::string();
       },
       false},
      {"erase",
       [](Act& a) {
         a.faces = blot(a.mesh, a.face, a.random);
         return erase_faces(a.mesh, a.before, a.faces, a.job);
       },
       [](const Act& a, const Partition& after) {
         const bool is_gone = after.region_count() < a.before.region_count();
         return changed_only(a, after, is_gone ? a.region : kNone, [&](auto from, auto) { return from == a.region; });
       }},
      {"grow", [](Act& a) { return grow_region(a.mesh, a.before, a.face, 1 + below(a.random, 3), a.job); },
       [](const Act& a, const Partition& after) {
         if (std::string wrong = count_is(after, a.before.region_count()); !wrong.empty()) return wrong;
         return changed_only(a, after, kNone, [&](auto from, auto) { return from != a.region; });
       }},
      {"shrink", [](Act& a) { return shrink_region(a.mesh, a.before, a.face, 1 + below(a.random, 2), a.job); },
       [](const Act& a, const Partition& after) {
         if (std::string wrong = count_is(after, a.before.region_count()); !wrong.empty()) return wrong;
         return changed_only(a, after, kNone, [&](auto from, auto) { return from == a.region; });
       }},
      {"lock",
       [](Act& a) {
         return set_locked(a.mesh, a.before, std::vector{a.face},
                           std::array{std::uint8_t{0}, kLocked, kLocked, kLeftOut}[a.random() % 4]);
       },
       [](const Act& a, const Partition& after) {
         return changed_only(a, after, kNone, [](auto, auto) { return false; });
       },
       false},
  };
}

/// Edits of the whole partition, which cost more and are tried at fewer faces.
std::vector<Edit> whole_edits() {
  const auto same_count = [](const Act& a, const Partition& after) { return count_is(after, a.before.region_count()); };
  return {
      {"add_worst", [](Act& a) { return add_worst(a.mesh, a.before, 2, a.job); },
       [](const Act& a, const Partition& after) { return count_is(after, a.before.region_count() + 2); }},
      {"delete_least", [](Act& a) { return delete_least(a.mesh, a.before, 2, a.job); },
       [](const Act& a, const Partition& after) { return count_is(after, a.before.region_count() - 2); }},
      {"merge_cheapest", [](Act& a) { return merge_cheapest(a.mesh, a.before, 2, a.job); },
       [](const Act& a, const Partition& after) { return count_is(after, a.before.region_count() - 2); }},
      {"improve", [](Act& a) { return improve(a.mesh, a.before, a.job); },
       [same_count](const Act& a, const Partition& after) {
         if (after.error > a.before.error * (1 + 1e-9) + 1e-12) return std::string("the error is larger");
         return same_count(a, after);
       }},
      {"even", [](Act& a) { return even_borders(a.mesh, a.before, 0.5, a.job); }, same_count},
      {"statistics",
       [](Act& a) {
         (void)all_statistics(a.mesh, a.before, a.job);
         (void)region_statistics(a.mesh, a.before, a.face, a.job);
         return a.before;
       },
       same_count},
      {"regularise", [](Act& a) { return regularise(a.mesh, a.before, {}, a.job); }, same_count},
  };
}

class Monkey {
 public:
  Monkey(const Mesh& mesh, std::string name, const Settings& settings, Tally& tally)
      : mesh_(mesh), name_(std::move(name)), settings_(settings), tally_(tally), random_(settings.seed) {
    for (auto& some : {single_edits(), brush_edits()}) edits_.insert(edits_.end(), some.begin(), some.end());
  }

  void run(const Partition& first) {
    ++tally_.partitions;
    check("partition", kNone, first);
    if (settings_.polygonize) polygonize_it("partition", first);
    std::vector<std::int32_t> small, some;
    choose_faces(first, small, some);
    for (const std::int32_t face : small)
      for (const Edit& edit : edits_) (void)act(edit, first, face);
    for (const std::int32_t face : some)
      for (int k = 0; k < settings_.edits_at_face; ++k) (void)act(edits_[below(random_, edits_.size())], first, face);
    for (const Edit& edit : whole_)
      (void)act(edit, first, below(random_, static_cast<std::size_t>(mesh_.face_count())));
    for (int k = 0; k < settings_.chains; ++k) chain(first, small);
  }

 private:
  [[nodiscard]] bool over() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count() > settings_.seconds;
  }

  void choose_faces(const Partition& p, std::vector<std::int32_t>& small, std::vector<std::int32_t>& some) {
    std::vector<std::vector<std::int32_t>> faces(p.region_seed.size());
    for (std::int32_t f = 0; f < mesh_.face_count(); ++f)
      if (p.face_region[f] >= 0) faces[p.face_region[f]].push_back(f);
    for (const auto& of_region : faces) {
      if (of_region.size() >= 4) continue;
      ++tally_.small_pieces;
      small.insert(small.end(), of_region.begin(), of_region.end());
    }
    std::shuffle(faces.begin(), faces.end(), random_);
    faces.resize(std::min<std::size_t>(faces.size(), static_cast<std::size_t>(settings_.random_regions)));
    for (auto& of_region : faces) {
      std::shuffle(of_region.begin(), of_region.end(), random_);
      of_region.resize(std::min<std::size_t>(of_region.size(), static_cast<std::size_t>(settings_.faces_of_region)));
      some.insert(some.end(), of_region.begin(), of_region.end());
    }
    for (int k = 0; k < settings_.random_faces; ++k)
      some.push_back(below(random_, static_cast<std::size_t>(mesh_.face_count())));
    std::shuffle(some.begin(), some.end(), random_);
  }

  void chain(const Partition& first, const std::vector<std::int32_t>& small) {
    Partition now = first;
    std::int32_t face = below(random_, static_cast<std::size_t>(mesh_.face_count()));
    for (int k = 0; k < settings_.chain && !over(); ++k) {
      if (random_() % 2 == 0) face = below(random_, static_cast<std::size_t>(mesh_.face_count()));
      if (!small.empty() && random_() % 4 == 0) face = small[below(random_, small.size())];
      const bool whole = random_() % 16 == 0;
      const Edit& edit = whole ? whole_[below(random_, whole_.size())] : edits_[below(random_, edits_.size())];
      if (std::optional<Partition> next = act(edit, now, face)) now = std::move(*next);
    }
    if (settings_.polygonize) polygonize_it("chain", now);
  }

  std::optional<Partition> act(const Edit& edit, const Partition& before, std::int32_t face) {
    if (over()) return std::nullopt;
    Tally::Count& count = tally_.edits[edit.name];
    Act made{.mesh = mesh_, .before = before, .face = face, .random = random_, .job = job_};
    try {
      Partition after = edit.run(made);
      ++count.done;
      std::string wrong = edit.check(made, after);
      if (wrong.empty() && edit.keeps_locked) wrong = locked_stay(made, after);
      if (!wrong.empty()) add(edit.name, face, wrong);
      if (check(edit.name, face, after)) return after;
    } catch (const InvalidInput& refused) {
      ++count.refused;
      if (std::string(refused.what()).find("several pieces") != std::string::npos) add(edit.name, face, refused.what());
    } catch (const std::exception& e) {
      add(edit.name, face, std::string("throws ") + e.what());
    }
    return std::nullopt;
  }

  bool check(const std::string& what, std::int32_t face, const Partition& p) {
    const std::string broken = broken_promise(Surface(mesh_, p.guided), p);
    if (!broken.empty()) add(what, face, broken);
    return broken.empty();
  }

  void polygonize_it(const std::string& what, const Partition& p) {
    if (over()) return;
    try {
      const PolygonMesh polygons = isimp::polygonize(mesh_, p, {}, job_);
      ++tally_.polygonized;
      const std::string defects = judge::defects_against(polygons, mesh_, p);
      if (!defects.empty() && polygons.report.without_area == 0 && !polygons.report.repair_capped)
        add("polygons of " + what, kNone, defects.substr(0, 300));
    } catch (const InvalidInput&) {
    } catch (const std::exception& e) {
      add("polygons of " + what, kNone, std::string("throws ") + e.what());
    }
  }

  void add(const std::string& what, std::int32_t face, const std::string& why) {
    std::ostringstream line;
    line << name_ << " seed " << settings_.seed << ": " << what << " at face " << face << ": " << why;
    tally_.findings.push_back(line.str());
  }

  const Mesh& mesh_;
  std::string name_;
  const Settings& settings_;
  Tally& tally_;
  Random random_;
  Job job_;
  std::vector<Edit> edits_, whole_ = whole_edits();
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::vector<VertexPair> some_edges(const Mesh& mesh, Random& random, int count) {
  std::vector<VertexPair> edges;
  std::int32_t h = below(random, 3 * static_cast<std::size_t>(mesh.face_count()));
  for (int k = 0; k < count; ++k) {  // a walk, so that some of them hang together
    edges.push_back({mesh.from(h), mesh.to(h)});
    h = Mesh::next(h);
    if (const std::int32_t o = mesh.opposite(h); o != kNone && random() % 3 != 0) h = Mesh::next(o);
    if (random() % 8 == 0) h = below(random, 3 * static_cast<std::size_t>(mesh.face_count()));
  }
  return edges;
}

/// Splits a mesh; a refusal is fine, any other exception is a fault.
std::optional<Partition> split(const Partitioner& partitioner, const PartitionOptions& options,
                               const Constraints& constraints, const std::string& name, Tally& tally) {
  Job job;
  try {
    return partitioner.run(options, constraints, job);
  } catch (const InvalidInput&) {
  } catch (const std::exception& e) {
    tally.findings.push_back(name + ": partition throws " + e.what());
  }
  return std::nullopt;
}

}  // namespace

std::int64_t Tally::actions() const {
  std::int64_t sum = 0;
  for (const auto& [unused, count] : edits) sum += count.done + count.refused;
  return sum;
}

void run(const Mesh& mesh, const Partition& partition, const std::string& name, const Settings& settings,
         Tally& tally) {
  Monkey(mesh, name, settings, tally).run(partition);
}

void run_all(const Mesh& mesh, const std::string& name, const std::vector<double>& details, bool guided,
             const Settings& settings, Tally& tally) {
  Random random(settings.seed);
  const Partitioner partitioner(mesh);
  const auto try_it = [&](const std::string& how, const PartitionOptions& options, const Constraints& constraints) {
    const auto made = split(partitioner, options, constraints, name + " " + how, tally);
    if (made) run(mesh, *made, name + " " + how, settings, tally);
    return made;
  };
  std::optional<Partition> last;
  for (const double detail : details)
    for (const double adaptivity : {0.0, 0.25})
      for (const double smooth : {0.0, 0.5}) {
        std::ostringstream how;
        how << "detail " << detail << " adaptivity " << adaptivity << " smooth " << smooth;
        last = try_it(how.str(), {.detail = detail, .adaptivity = adaptivity, .smooth = smooth}, {});
      }
  if (!guided) return;
  const PartitionOptions plain{.detail = details.back()};
  const std::int32_t few = std::min(mesh.face_count(), 20);
  try_it("proxies", {.proxies = few}, {});
  try_it("proxies lloyd", {.proxies = few, .method = Method::lloyd}, {});
  try_it("bound", {.bound = 0.01 * mesh.diagonal()}, {});
  const std::vector<VertexPair> edges = some_edges(mesh, random, 40);
  try_it("barriers", plain, {.guides = {.weights = {}, .barriers = edges}});
  try_it("cuts", plain, {.guides = {}, .cuts = edges});
  std::vector<double> weights(static_cast<std::size_t>(mesh.face_count()));
  for (double& w : weights) w = random() % 3 == 0 ? 0.0 : static_cast<double>(1 + random() % 100);
  try_it("weights", plain, {.guides = {.weights = weights, .barriers = {}}});
  if (!last) return;
  Job job;
  std::vector<std::int32_t> faces;
  for (int k = 0; k < 5; ++k) faces.push_back(below(random, static_cast<std::size_t>(mesh.face_count())));
  std::erase_if(faces, [&](std::int32_t f) { return last->face_region[f] == kNone; });
  if (faces.empty()) return;
  const Partition locked = set_locked(mesh, *last, faces, kLocked);
  Constraints constraints;
  constraints.before = &locked;
  try_it("locked", plain, constraints);
  constraints.faces = std::vector<std::int32_t>();
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (middle_of(mesh, f).x() < middle_of(mesh, faces[0]).x()) constraints.faces->push_back(f);
  if (!constraints.faces->empty()) try_it("some faces", plain, constraints);
}

std::string report(const Tally& tally) {
  std::ostringstream text;
  for (const auto& [name, count] : tally.edits)
    text << name << ": " << count.done << " done, " << count.refused << " refused\n";
  text << tally.partitions << " partitions with " << tally.small_pieces << " small regions, " << tally.actions()
       << " edits, " << tally.polygonized << " polygonized, " << tally.findings.size() << " findings\n";
  for (const std::string& finding : tally.findings) text << finding << '\n';
  return text.str();
}

}  // namespace isimp::monkey
