#pragma once

#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "isimp/mesh/found_opening.h"
#include "isimp/mesh/mesh.h"
#include "isimp/simplify/partitioner.h"

namespace isimp::bindings {

/// A mesh as Python holds it: with its Partitioner, its vertices as the caller gave them, and the openings that `clean`
/// found.
class KeptMesh : public Mesh {
 public:
  explicit KeptMesh(Mesh&& mesh, std::vector<FoundOpening> openings = {})
      : Mesh(std::move(mesh)), partitioner_(*this), openings_(std::move(openings)) {}

  [[nodiscard]] const Partitioner& partitioner() const { return partitioner_; }
  /// (V) in the caller's coordinates; made at the first use if these are not the mesh's own.
  [[nodiscard]] std::span<const Vec3> placed_vertices() const;
  [[nodiscard]] const std::vector<FoundOpening>& openings() const { return openings_; }

 private:
  Partitioner partitioner_;
  std::vector<FoundOpening> openings_;
  mutable std::once_flag once_placed_;
  mutable std::vector<Vec3> placed_;  // empty where `origin` is zero
};

}  // namespace isimp::bindings
