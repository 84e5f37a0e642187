#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "discs/labels.h"
#include "isimp/core/threads.h"
#include "isimp/partition/partition.h"

namespace isimp::meshing {

/// The plane of a chart, with the moments of its surface. Outlying faces count a thousandth.
struct Plane {
  Vec3 normal = Vec3::UnitZ();  ///< unit; area-weighted mean of its faces'
  Vec3 centre = Vec3::Zero();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();  ///< covariance of the surface about the centre
  double area = 0;
  bool held = false;     ///< the plane is given, through `centre`
  bool snapped = false;  ///< it is by `regularise`, held or not
  bool round = false;    ///< it is that of a cell of a round part
  double projected = 0;  ///< length of the vector area; 0 where the faces define no direction
};

/// Distortion of the surface of a plane: the sum of area * |n_face - normal|^2.
inline double error_of(const Plane& p) { return 2 * (p.area - p.projected); }
/// The sum of area * square distance of the surface from the plane, infinitesimal parts of the surface counted.
inline double square_of(const Plane& p) { return p.area * p.normal.dot(p.spread * p.normal); }

/// The units of the limits of meshing.
struct Scale {
  double size = 0;       ///< sqrt(area / charts), scene units
  double deviation = 0;  ///< root mean square distance of the scan from the planes of the charts, scene units
  double error = 0;      ///< mean of `error_of` over the charts
  double square = 0;     ///< mean of `square_of` over the charts
};
/// Cost: O(charts).
Scale scale_of(const Labels& labels, std::span<const Plane> planes);

/// The planes of all charts.
/// Cost: O(F).
std::vector<Plane> planes_of(const Labels& labels, const Threads& threads, const Job& job);

/// The plane of one chart from its faces.
/// \param outlying  (F) or empty: none is
Plane plane_of(const Mesh& mesh, std::span<const std::int32_t> faces, std::span<const std::uint8_t> outlying = {});

/// The direction in which the surface spreads least, on the side of the mean normal.
Vec3 best_normal(const Plane& plane);

/// Marks the outliers among the faces of a region, such as those of a rounded edge: faces more than six times as far from
/// the plane of the others as half of the region's area is.
/// \param outlying  (F) 0 for these faces, then 1 for outliers
/// Cost: O(faces) a turn, up to twenty turns where there are outliers.
/// Source: least trimmed squares (Rousseeuw 1984), by the median of the distances in place of a share of the faces.
void mark_outlying(const Mesh& mesh, std::span<const std::int32_t> faces, std::span<std::uint8_t> outlying);

/// Whether each face is an outlier of its region.
/// \return (F) 0 or 1
std::vector<std::uint8_t> outlying_faces(const Mesh& mesh, std::span<const std::int32_t> face_region,
                                         std::int32_t regions, const Threads& threads, const Job& job);

/// Turns the plane of a chart into the one that the partition holds for its region, if it does.
/// \param origin  of the mesh
void hold(Plane& plane, const Partition& partition, std::int32_t region, const Vec3& origin);

/// Calls `hold` if the plane was set by hand. Snapped planes are applied last, because defects can release them.
void hold_by_hand(Plane& plane, const Partition& partition, std::int32_t region, const Vec3& origin);

/// The plane of two charts together, both with `projected` above 0.
Plane united(const Plane& a, const Plane& b);

/// The plane of `chart` minus `part`. Pre: part.area < chart.area.
Plane without(const Plane& chart, const Plane& part);

/// rounding: planes of cells whose eigenvalues have a smaller share of the largest are parallel: see step_onto.
constexpr double kParallel = 1e-6;

/// The shortest step from a point to where planes meet, in the directions that they fix.
/// \param fixed  share of the largest eigenvalue of the normals, below which a direction is not fixed
/// \param free   projects to the directions in which the point may move; fixed directions are removed
Vec3 step_onto(std::span<const Plane* const> planes, double fixed, const Vec3& from, Eigen::Matrix3d& free);

}  // namespace isimp::meshing
