#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>

#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"

namespace isimp::bindings {

/// A mesh as Python holds it: with the hierarchy of its last partition, which makes another number of proxies quick.
class KeptMesh : public Mesh {
 public:
  explicit KeptMesh(Mesh&& mesh) : Mesh(std::move(mesh)) {}

  /// partition(*this, options, job), from the kept hierarchy where it serves. May be called from several threads.
  [[nodiscard]] Partition split(const PartitionOptions& options, Job& job) const;

 private:
  [[nodiscard]] std::shared_ptr<const Hierarchy> kept(std::int32_t proxies) const;

  mutable std::mutex mutex_;
  mutable std::shared_ptr<const Hierarchy> hierarchy_;
};

}  // namespace isimp::bindings
