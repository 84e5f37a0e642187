#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"
#include "region_planes.h"

namespace isimp::regular {

/// The plane of a cell: normal * x = offset.
struct CellPlane {
  std::int32_t region = kNone;
  Vec3 normal = Vec3::UnitZ();
  double offset = 0;
};

/// The axes and radii of the round parts of a partition, and their moves. Parts of one axis form a group, and so do a
/// bend and its pipes. The cells of a group move rigidly.
class RoundAxes {
 public:
  /// \param planes  (R) of the partition's regions
  RoundAxes(const Mesh& mesh, const Partition& partition, const std::vector<RegionPlane>& planes);

  [[nodiscard]] std::size_t size() const { return groups_.size(); }
  /// The axis of a group in the place of a plane's normal. A turn of this plane adds as much to its distance as the same
  /// turn of the axis adds to the distance of the cells from the scan.
  [[nodiscard]] const RegionPlane& axis(std::size_t group) const { return groups_[group].axis; }

  /// Turns the axis of a group about the middle of its cells.
  void turn(std::size_t group, const Vec3& axis);
  /// Moves the group of a part to an axis through a point, and gives the part a radius if it has one of its own.
  void place(std::int32_t number, const Vec3& point, const Vec3& axis, double radius);
  /// Makes nearly equal axes of turned groups one axis, and nearly equal radii of cylinders and spheres equal.
  /// \param reach  by group: the largest root mean square distance by which its cells may move
  void share(std::span<const double> reach);
  /// Returns a group to its first axis and radii.
  void release(std::size_t group);

  /// The sum of area times squared distance of the cells of a group from their first planes.
  [[nodiscard]] double before(std::size_t group) const;
  /// The increase of this sum by the moves of a group.
  [[nodiscard]] double added(std::size_t group) const;
  /// The planes of all cells that were moved.
  [[nodiscard]] std::vector<CellPlane> cells() const;
  /// Stores axes, points and radii, and counts shared axes and equal radii.
  void store(std::vector<CurvedProxy>& parts, RegularAxes& found) const;

 private:
  struct RoundPart {
    std::int32_t number = kNone;  ///< in Partition::curved
    CurvedProxy first;            ///< relative to the mesh's origin
    double radius = 0, area = 0;
    bool has_radius = false;  ///< that may change: a full cylinder or a sphere, no pipe of a bend
    bool is_on_axis = false;  ///< its axis is that of the group
    std::vector<CellPlane> cells;
  };
  struct Group {
    std::vector<RoundPart> parts;  ///< the first one leads
    RegionPlane axis;
    Vec3 middle = Vec3::Zero(), line = Vec3::Zero(), shift = Vec3::Zero();  ///< `line` is on the axis
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();  ///< mean of n n^T of the cells
    bool is_turned = false;
  };

  void add_cells(const Partition& partition, std::vector<RoundPart>& parts) const;
  void group_up(std::vector<RoundPart> parts, double apart);
  void measure(Group& group) const;
  void share_axes(std::span<const double> reach);
  void share_radii(std::span<const double> reach);
  [[nodiscard]] CurvedProxy moved(const Group& group, const RoundPart& part) const;
  template <class Visit>
  void for_each_cell(const Group& group, Visit visit) const;

  Vec3 origin_;
  std::vector<RegionPlane> regions_;
  std::vector<Group> groups_;
};

}  // namespace isimp::regular
