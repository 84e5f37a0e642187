#pragma once

#include <memory>
#include <string>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/partition/partition.h"
#include "isimp/partition/surface.h"

namespace isimp {

struct Hierarchy;

/// The methods of the 2004 paper and of the thesis: lloyd and teleport, the data-parallel floodings naive and queued,
/// and hybrid. Method::hierarchy does not use them, and a build with ISIMP_THESIS=OFF lacks them.
///
/// It keeps data for the next call: the surface in the memory of a back end, and the decimated mesh. May be used from
/// several threads.
class Thesis {
 public:
  Thesis();
  Thesis(const Thesis&) = delete;
  Thesis& operator=(const Thesis&) = delete;
  ~Thesis();

  /// Whether this build has the methods.
  [[nodiscard]] static bool is_built();

  /// \throws InvalidInput  a method or a back end that is not in this build, or a back end that does not work here: the
  ///                       message gives the reason and the choices
  static void check(const PartitionOptions& options);

  /// Exactly options.proxies regions, or the number that the components need, by any method except Method::hierarchy.
  /// \param hierarchy  a hierarchy for this surface and number, if `needs_hierarchy`; else an empty one
  /// \param options    checked, with `proxies`
  /// \throws InvalidInput  hybrid: the decimated mesh has fewer faces than `proxies`
  /// \throws Error         a device has too little memory or failed
  /// Cost: O(iterations * F); hybrid O(F log F).
  /// Source: Cohen-Steiner, Alliez, Desbrun 2004, section 3, and the thesis.
  Partition by_number(const Surface& surface, const Hierarchy& hierarchy, const PartitionOptions& options,
                      Job& job) const;

 private:
  struct Kept;
  std::unique_ptr<Kept> kept_;
};

/// The names that PartitionOptions::backend accepts here: "cpu" always, "cuda" where a device is present.
[[nodiscard]] std::vector<std::string> backends();

}  // namespace isimp
