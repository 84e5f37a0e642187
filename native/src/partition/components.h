// The components of a surface, and their shares of the regions.
#pragma once

#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/partition/metric.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// A connected component of the surface, and the number of regions that it may have.
struct Component {
  RegionSum sum;           ///< sum of all its faces; areas as shares of the whole surface
  double area = 0.0;       ///< as a share of the whole surface
  bool closed = true;      ///< no border
  bool kept = true;        ///< false: left out, its faces get no region
  std::int32_t need = 1;   ///< the least number of regions: 4 if closed, else 1; never more than its faces
  std::int32_t first = 0;  ///< its first face in the order of the face graph
};

/// All components.
struct Components {
  std::vector<Component> all;  ///< (C), as surface.component() numbers them
  std::int32_t asked = 0;      ///< options.proxies
  std::int32_t needed = 0;     ///< sum of `need` over the kept components
  std::int32_t left_out = 0;   ///< number of components of the mesh left out
  double area_left_out = 0.0;  ///< their share of the whole surface

  /// The number of regions in all.
  [[nodiscard]] std::int32_t regions() const { return asked > needed ? asked : needed; }
};

/// Finds the components and decides which are kept: each below `leave_out` of the area is left out, smallest first,
/// while all of them together stay below ten times that. They may have up to twenty times that where each has less than
/// a tenth of the mean area of `proxies` regions: it would get up to four of them. The largest is always kept, and none
/// is left out where the rest would have fewer than `proxies` faces. The decision uses components of the mesh, and true
/// areas without the guides.
/// Cost: O(F + C log C).
/// \param proxies   1 if the number of regions is not known yet
/// \param measured  the components if they are known already (see Hierarchy::components)
Components find_components(const Surface& surface, std::int32_t proxies, double leave_out, Job& job,
                           std::vector<Component> measured = {});

/// The figures that decide whether a component is kept.
struct Body {
  double area = 0.0;
  std::int64_t faces = 0;
  bool kept = true;
};

struct LeftOut {
  std::int32_t count = 0;
  double area = 0.0;
};

/// Decides which bodies are kept, by the rule of find_components.
/// \param leave_out  an area, in the unit of the bodies' own
/// Cost: O(C log C).
LeftOut choose_left_out(std::vector<Body>& bodies, std::int32_t proxies, double leave_out);

/// The least number of regions of a component.
std::int32_t least_regions(bool closed, std::int64_t faces);

/// The number of regions of each component: 0 if left out, else its need, and of the rest a share by size and
/// curvature.
///
/// With N regions on a component, its error falls like kappa / N; the least sum of errors has N proportional to
/// sqrt(kappa). kappa is the error of a single region. Shares are rounded by largest remainder, ties to the component
/// of the lower number; none gets more than its faces.
std::vector<std::int32_t> share_out(const Components& components);

}  // namespace isimp
