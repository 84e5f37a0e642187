// Planes of regions that are set by hand.
#include "isimp/interact/merge.h"
#include "isimp/interact/paint.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/regular/align_planes.h"
#include "isimp/regular/regularise.h"
#include "isimp/simplify/partitioner.h"
#include "labelled.h"
#include "polygon_judge.h"
#include "tests.h"

namespace isimp {
namespace {

constexpr double kExact = 1e-12;
const Vec3 kUp = Vec3::UnitZ();

/// A cube of side 1, its top tilted by `slope` along x and its side at +x by `lean`, both about their middles.
struct Leaning {
  Mesh mesh;
  Partition part;
  explicit Leaning(double slope = 0.03, double lean = 0.02) : mesh(made(slope, lean)), part(sides(mesh)) {}

  static Mesh made(double slope, double lean) {
    shapes::Arrays a = shapes::cube(8);
    for (Vec3& v : a.vertices) {
      if (v.z() > 0.999) v.z() += slope * (v.x() - 0.5);
      if (v.x() > 0.999) v.x() += lean * (v.z() - 0.5);
    }
    return shapes::mesh(a);
  }
  static Partition sides(const Mesh& mesh) {
    return partition_from(mesh, labelled::planes(shapes::mesh(shapes::cube(8))).face_region, job());
  }

  /// A face of the side that faces along an axis.
  [[nodiscard]] std::int32_t face(const Vec3& axis) const {
    std::int32_t best = 0;
    double most = -2;
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      const Vec3 n = part.region_sum[part.face_region[f]].normal();
      if (n.dot(axis) > most) {
        most = n.dot(axis);
        best = f;
      }
    }
    return best;
  }
  [[nodiscard]] std::int32_t top() const { return face(Vec3::UnitZ()); }
  [[nodiscard]] std::int32_t side() const { return face(Vec3::UnitX()); }
  [[nodiscard]] std::int32_t front() const { return face(-Vec3::UnitY()); }
  [[nodiscard]] std::int32_t region(std::int32_t f) const { return part.face_region[f]; }

  [[nodiscard]] Partition aligned(const std::vector<std::int32_t>& faces, Align to, std::optional<double> length = {},
                                  const Vec3& up = kUp) const {
    return aligned(part, faces, to, length, up);
  }
  [[nodiscard]] Partition aligned(const Partition& p, const std::vector<std::int32_t>& faces, Align to,
                                  std::optional<double> length = {}, const Vec3& up = kUp) const {
    return align_planes(mesh, p, faces, to, up, length, job());
  }
  [[nodiscard]] std::string refusal(const std::vector<std::int32_t>& faces, Align to, std::optional<double> length = {},
                                    const Vec3& up = kUp) const {
    return message_of([&] { (void)aligned(faces, to, length, up); });
  }
};

TEST(AlignPlanes, LevelAndUprightTurnAboutTheMiddle) {
  const Leaning cube;
  const Partition level = cube.aligned({cube.top()}, Align::level);
  const std::int32_t top = cube.region(cube.top());
  EXPECT_EQ(level.face_region, cube.part.face_region);
  EXPECT_EQ(level.region_held[top], kPlaneByHand);
  EXPECT_EQ(std::count(level.region_held.begin(), level.region_held.end(), 0), 5);
  EXPECT_LT((level.region_normal[top] - kUp).norm(), kExact);
  EXPECT_NEAR(level.region_offset[top], 1.0, 1e-3);
  ASSERT_TRUE(level.regularity);
  EXPECT_EQ(level.regularity->by_hand, 1);
  EXPECT_EQ(level.regularity->free, 5);
  EXPECT_GT(level.regularity->rms, level.regularity->rms_before);

  const Partition upright = cube.aligned({cube.side()}, Align::upright);
  const std::int32_t side = cube.region(cube.side());
  EXPECT_LT((upright.region_normal[side] - Vec3::UnitX()).norm(), 1e-9);
  EXPECT_EQ(upright.region_normal[side].dot(kUp), 0.0);
}

TEST(AlignPlanes, UpIsWhatItIsSaidToBe) {
  const Leaning cube;
  const Vec3 up = Vec3(0, 0, 5) + 5 * Vec3(0.03, 0, 0);
  const Partition level = cube.aligned({cube.top()}, Align::level, {}, up);
  EXPECT_LT((level.region_normal[cube.region(cube.top())] - up.normalized()).norm(), kExact);
}

TEST(AlignPlanes, TheFirstLeadsOthersParallelAndPerpendicular) {
  const Leaning cube;
  const std::int32_t side = cube.region(cube.side()), top = cube.region(cube.top());
  const std::int32_t back = cube.face(-Vec3::UnitX());
  const Partition parallel = cube.aligned({back, cube.side()}, Align::parallel);
  EXPECT_LT((parallel.region_normal[side] + parallel.region_normal[cube.region(back)]).norm(), kExact);
  EXPECT_LT((parallel.region_normal[side] - Vec3::UnitX()).norm(), 1e-9);
  EXPECT_EQ(parallel.region_held[cube.region(back)], kPlaneByHand);

  const Partition square = cube.aligned({cube.side(), cube.top()}, Align::perpendicular);
  EXPECT_LT(std::abs(square.region_normal[side].dot(square.region_normal[top])), kExact);
  EXPECT_GT(square.region_normal[side].dot(kUp), -0.03);
  EXPECT_LT(square.region_normal[side].dot(kUp), -0.01) << "the leading plane stays as it is";
}

TEST(AlignPlanes, AnUprightWallStaysSoAsItIsMadePerpendicular) {
  const Leaning cube(0.0, 0.02);
  const std::int32_t side = cube.region(cube.side()), front = cube.region(cube.front());
  const Partition upright = cube.aligned({cube.side(), cube.front()}, Align::upright);
  const Partition square = cube.aligned(upright, {cube.front(), cube.side()}, Align::perpendicular);
  EXPECT_LT(std::abs(square.region_normal[side].dot(kUp)), kExact);
  EXPECT_LT(std::abs(square.region_normal[side].dot(square.region_normal[front])), kExact);
}

TEST(AlignPlanes, CoplanarRegionsGetOnePlane) {
  shapes::Arrays a = shapes::plane(12);
  for (Vec3& v : a.vertices) v.z() = v.x() > 0.5 ? 0.01 : 0.0;
  const Mesh mesh = shapes::mesh(a);
  const auto label = shapes::labels(mesh, [](const Vec3& p) { return p.x() < 0.45 ? 0 : p.x() > 0.6 ? 2 : 1; });
  const Partition part = partition_from(mesh, label, job());
  const auto face = [&](std::int32_t r) {
    return static_cast<std::int32_t>(std::find(label.begin(), label.end(), r) - label.begin());
  };
  const std::vector<std::int32_t> outer{face(0), face(2)};
  const Partition one = align_planes(mesh, part, outer, Align::coplanar, kUp, 0.1, job());
  EXPECT_LT((one.region_normal[0] - one.region_normal[2]).norm(), kExact);
  EXPECT_NEAR(one.region_offset[0], one.region_offset[2], kExact);
  // A plane that is set already is kept.
  const Partition lead = align_planes(mesh, part, std::vector{face(2)}, Align::level, kUp, {}, job());
  const std::vector<std::int32_t> from_2{face(2), face(0)};
  const Partition two = align_planes(mesh, lead, from_2, Align::coplanar, kUp, 0.1, job());
  EXPECT_EQ(two.region_offset[2], lead.region_offset[2]);
  EXPECT_EQ(two.region_offset[0], lead.region_offset[2]);
}

TEST(AlignPlanes, RefusesWhatMovesTheScanTooFarAndSaysByHowMuch) {
  const Leaning cube(0.2, 0.0);
  const std::string name = "the region of face " + std::to_string(cube.top());
  // A slope of .2 over a side of 1: root mean square .2 / sqrt(12), less the gain by turning.
  EXPECT_EQ(cube.refusal({cube.top()}, Align::level, 0.02), name + " needs 0.05774, allowed 0.02");
  EXPECT_EQ(cube.refusal({cube.top()}, Align::level), name + " needs 0.05774, allowed 0.01792");
  EXPECT_EQ(cube.refusal({cube.top()}, Align::level, 0.06), "no error");
  EXPECT_EQ(cube.refusal({cube.front()}, Align::level),
            "the region of face " + std::to_string(cube.front()) + " is square to the plane that it should have");
}

TEST(AlignPlanes, RefusesWrongUse) {
  const Leaning cube;
  EXPECT_EQ(cube.refusal({}, Align::level), "there is no face: name one of each region");
  EXPECT_EQ(cube.refusal({-1}, Align::level), "face must be in [0, 768), got -1");
  EXPECT_EQ(cube.refusal({768}, Align::free), "face must be in [0, 768), got 768");
  for (const Align to : {Align::parallel, Align::perpendicular, Align::coplanar})
    EXPECT_EQ(cube.refusal({cube.top(), cube.top()}, to), "all faces are in one region: name faces of two or more");
  EXPECT_EQ(cube.refusal({cube.top()}, Align::level, 0.0), "length must be a finite length above 0, got 0");
  EXPECT_EQ(cube.refusal({cube.top()}, Align::level, {}, Vec3::Zero()),
            "up_direction must be a direction: three finite numbers, not all 0");
  Partition other = cube.part;
  other.face_region.pop_back();
  EXPECT_THROW((void)cube.aligned(other, {cube.top()}, Align::level), InvalidInput);
  Partition without = cube.part;
  for (std::int32_t& r : without.face_region)
    if (r == cube.region(cube.top())) r = kNone;
  EXPECT_THROW((void)cube.aligned(without, {cube.top()}, Align::level), InvalidInput);
}

/// A sheet of four regions, flattened to a line along an axis.
struct Line {
  Mesh mesh = made();
  Partition part = quarters(mesh);

  static Mesh made() {
    shapes::Arrays a = shapes::plane(8);
    for (Vec3& v : a.vertices) v = Vec3(v.x() + 0.1 * v.y(), 0, 0);
    return shapes::mesh(a);
  }
  static Partition quarters(const Mesh& mesh) {
    std::vector<std::int32_t> label;
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) label.push_back(f * 4 / mesh.face_count());
    return partition_from(mesh, label, job());
  }
};

TEST(AlignPlanes, RegionsWithoutAreaHaveNoPlaneInCommon) {
  const Line line;
  const auto align = [&](const std::vector<std::int32_t>& faces) {
    return align_planes(line.mesh, line.part, faces, Align::coplanar, kUp, 100.0, job());
  };
  const std::string first = std::to_string(line.part.region_seed[0]);
  EXPECT_EQ(message_of([&] { (void)align(line.part.region_seed); }),
            "the region of face " + first + " and the others have no area, so no plane fits them");
}

TEST(AlignPlanes, PlanesThatAreNotFiniteAreRefusedByName) {
  const Leaning cube;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Partition set = cube.aligned({cube.top()}, Align::level);
  std::vector<Partition> damaged(2, set);
  damaged[0].region_normal[3].y() = nan;
  damaged[1].region_offset[3] = nan;
  for (const Partition& part : damaged) {
    EXPECT_EQ(message_of([&] { (void)polygonize(cube.mesh, part, {}, job()); }), "the plane of region 3 is not finite");
    EXPECT_THROW((void)regularise(cube.mesh, part, {}, job()), InvalidInput);
    EXPECT_THROW((void)region_fits(cube.mesh, part), InvalidInput);
    EXPECT_THROW((void)cube.aligned(part, {cube.top()}, Align::free), InvalidInput);
  }
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(cube.refusal({cube.top()}, Align::level, infinity), "length must be a finite length above 0, got inf");
}

TEST(AlignPlanes, ItAndRegularisePollForEachRegion) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::plane(16), 0.01, 1));
  std::vector<std::int32_t> label(mesh.face_count());
  for (std::size_t f = 0; f < label.size(); ++f) label[f] = static_cast<std::int32_t>(f);
  const Partition part = partition_from(mesh, label, job());
  const auto polls = [&](const auto& call) {
    Counting counting;
    call(counting.job);
    return counting.polls.load();
  };
  EXPECT_GE(polls([&](Job& j) { (void)align_planes(mesh, part, std::vector{0}, Align::level, kUp, 1.0, j); }),
            part.region_count());
  EXPECT_GE(polls([&](Job& j) { (void)regularise(mesh, part, {}, j); }), 2 * part.region_count());
}

TEST(AlignPlanes, PolygonsKeepToThem) {
  const Leaning cube;
  const Partition part =
      cube.aligned(cube.aligned({cube.top()}, Align::level), {cube.side(), cube.front()}, Align::upright);
  const PolygonMesh out = polygonize(cube.mesh, part, {.planar = true}, job());
  ASSERT_EQ(out.polygon_count(), 6);
  const std::vector<judge::Loop> loops = judge::polygons_of(out);
  for (std::int32_t q = 0; q < 6; ++q) {
    const std::int32_t r = out.polygon_region[q];
    if (part.region_held[r] != kPlaneByHand) continue;
    for (const std::int32_t v : loops[q]) {
      const double off = part.region_normal[r].dot(out.vertices[v]) - part.region_offset[r];
      EXPECT_LT(std::abs(off), 1e-7 * cube.mesh.diagonal());
    }
  }
}

/// A sheet that is folded along x = .5 by a slope of .2, its halves as regions.
struct Fold {
  Mesh mesh = made();
  Partition part = halves(mesh);

  static Mesh made() {
    shapes::Arrays a = shapes::plane(12);
    for (Vec3& v : a.vertices) v.z() = 0.2 * std::max(0.0, v.x() - 0.5);
    return shapes::mesh(a);
  }
  static Partition halves(const Mesh& mesh) {
    const auto half = [&](const Vec3& p) { return p.x() + mesh.origin().x() < 0.5 ? 0 : 1; };
    return partition_from(mesh, shapes::labels(mesh, half), job());
  }
};

TEST(AlignPlanes, SnappedPlanesThatDoNotMeetAreLetGoAndThoseSetByHandAreNot) {
  const Fold fold;
  const Partition snapped = regularise(fold.mesh, fold.part, {.angle = 15, .length = 0.04}, job());
  ASSERT_EQ(snapped.regularity->directions, 1);
  ASSERT_EQ(snapped.regularity->planes, 2) << "parallel planes with a common edge";
  const PolygonMesh out = polygonize(fold.mesh, snapped, {.planar = true}, job());
  EXPECT_EQ(out.polygon_count(), 2);
  EXPECT_EQ(out.report.planar.whole, 1.0);
  EXPECT_GE(out.report.planes_let_go, 1);
  const std::vector<std::int32_t> faces{fold.part.region_seed[0], fold.part.region_seed[1]};
  const Partition by_hand = align_planes(fold.mesh, fold.part, faces, Align::level, kUp, 0.1, job());
  const PolygonMesh kept = polygonize(fold.mesh, by_hand, {.planar = true}, job());
  EXPECT_EQ(kept.report.planes_let_go, 0);
  EXPECT_TRUE(kept.report.planar.planar);
}

TEST(AlignPlanes, RegulariseKeepsThemAndLeavesFreedOnesFree) {
  const Leaning cube(0.03, 0.0);
  const std::int32_t top = cube.region(cube.top()), side = cube.region(cube.side());
  Partition part = cube.aligned({cube.side()}, Align::free);
  EXPECT_EQ(part.region_held[side], kPlaneFree);
  EXPECT_FALSE(part.is_held(side));
  // Up is square to the sloping top, which regularise would not call level otherwise.
  const Vec3 tilted = Vec3(-0.03, 0, 1).normalized();
  part = cube.aligned(part, {cube.top()}, Align::level, {}, tilted);
  const Partition all = regularise(cube.mesh, part, {.angle = 8, .length = 0.05}, job());
  EXPECT_EQ(all.region_held[top], kPlaneByHand);
  EXPECT_EQ(all.region_normal[top], part.region_normal[top]);
  EXPECT_EQ(all.region_offset[top], part.region_offset[top]);
  EXPECT_EQ(all.region_held[side], kPlaneFree);
  ASSERT_TRUE(all.regularity);
  EXPECT_EQ(all.regularity->by_hand, 1);
  EXPECT_EQ(std::count(all.region_held.begin(), all.region_held.end(), kPlaneSnapped), 4);
}

TEST(AlignPlanes, APlaneSetByHandCostsTheOthersNothing) {
  const Leaning cube(0.03, 0.0);  // no noise: the least addition to the distance would be above all
  const Partition part = cube.aligned({cube.top()}, Align::level);
  const Partition all = regularise(cube.mesh, part, {}, job());
  EXPECT_EQ(all.regularity->by_hand, 1);
  EXPECT_EQ(all.regularity->level, 1);
  EXPECT_EQ(all.regularity->upright, 4);
  EXPECT_EQ(all.regularity->directions, 3);
}

TEST(AlignPlanes, FreeLetsGoOfWhatWasSnapped) {
  const Leaning cube;
  const Partition snapped = regularise(cube.mesh, cube.part, {.angle = 8, .length = 0.05}, job());
  const std::int32_t top = cube.region(cube.top());
  ASSERT_EQ(snapped.region_held[top], kPlaneSnapped);
  const Partition freed = cube.aligned(snapped, {cube.top()}, Align::free);
  EXPECT_FALSE(freed.is_held(top));
  EXPECT_EQ(freed.regularity->free, 1);
  const Partition again = regularise(cube.mesh, freed, {.angle = 8, .length = 0.05}, job());
  EXPECT_FALSE(again.is_held(top));
  EXPECT_EQ(again.regularity->level, 1);
}

TEST(AlignPlanes, EditsKeepWhatTheyHardlyChange) {
  const Leaning cube;
  const std::int32_t top = cube.region(cube.top()), side = cube.region(cube.side());
  const Partition part =
      cube.aligned(cube.aligned({cube.top()}, Align::level), {cube.side(), cube.front()}, Align::upright);
  const Partition merged = merge_regions(cube.mesh, part, cube.face(-Vec3::UnitZ()), cube.front(), job());
  EXPECT_EQ(std::count(merged.region_held.begin(), merged.region_held.end(), kPlaneByHand), 2);
  for (const std::int32_t face : {cube.top(), cube.side()}) {
    const std::int32_t was = cube.region(face), is = merged.face_region[face];
    EXPECT_EQ(merged.region_held[is], kPlaneByHand);
    EXPECT_EQ(merged.region_normal[is], part.region_normal[was]);
    EXPECT_EQ(merged.region_offset[is], part.region_offset[was]);
  }
  // One face fewer hardly changes a region; half of it does.
  std::vector<std::int32_t> some, half;
  for (std::int32_t f = 0; f < cube.mesh.face_count(); ++f) {
    if (part.face_region[f] != top) continue;
    if (some.empty()) some.push_back(f);
    if (cube.mesh.vertices()[cube.mesh.triangles()[f][0]].x() + cube.mesh.origin().x() < 0.4) half.push_back(f);
  }
  const Partition one = paint_faces(cube.mesh, part, some, kNone, job());
  EXPECT_EQ(one.region_held[top], kPlaneByHand);
  EXPECT_EQ(one.region_held[side], kPlaneByHand);
  EXPECT_EQ(one.region_held.back(), 0);
  EXPECT_EQ(paint_faces(cube.mesh, part, half, kNone, job()).region_held[top], 0);
}

TEST(AlignPlanes, APartitionOfSomeFacesKeepsThePlanesOfTheOthers) {
  const Leaning cube;
  const Partition part = cube.aligned(cube.aligned({cube.top()}, Align::level), {cube.side()}, Align::upright);
  std::vector<std::int32_t> faces;
  for (std::int32_t f = 0; f < cube.mesh.face_count(); ++f)
    if (part.face_region[f] == cube.region(cube.top())) faces.push_back(f);
  Constraints some;
  some.faces = faces;
  some.before = &part;
  const Partition split = Partitioner(cube.mesh).run({.proxies = 3}, some, job());
  const std::int32_t is = split.face_region[cube.side()];
  EXPECT_EQ(split.region_held[is], kPlaneByHand);
  EXPECT_EQ(split.region_normal[is], part.region_normal[cube.region(cube.side())]);
  EXPECT_EQ(split.region_offset[is], part.region_offset[cube.region(cube.side())]);
  EXPECT_EQ(split.region_held[split.face_region[cube.top()]], 0);
  EXPECT_EQ(std::count(split.region_held.begin(), split.region_held.end(), kPlaneByHand), 1);
}

}  // namespace
}  // namespace isimp
