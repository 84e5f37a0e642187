#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "isimp/core/errors.h"
#include "parallel_lloyd.h"

namespace isimp {

/// Keeps a surface in the memory of a back end from one partition to the next. May be used from several threads.
class KeptFlooder {
 public:
  /// Calls use(flooder) with the surface in the memory of a back end: as kept since the last call, if that was for the
  /// same surface and back end. A flooder kept for another one is freed first, so that a device never holds two; so is
  /// the one in use when something failed. While one caller has it, another one gets its own.
  /// \param surface  its mesh must outlive this
  /// \throws InvalidInput, Error  as load(); and the errors of use()
  template <class Use>
  auto with(const Surface& surface, const std::string& backend, Use use) const {
    Loaded loaded = take(surface, backend);
    try {
      auto result = use(*loaded.flooder);
      keep(std::move(loaded));
      return result;
    } catch (const Cancelled&) {
      keep(std::move(loaded));
      throw;
    }
  }

 private:
  struct Loaded {
    std::string backend;
    std::shared_ptr<const GuidedGraph> guided;  // owns the graph, unless the mesh does
    const FaceGraph* graph = nullptr;
    std::unique_ptr<parallel::Flooder> flooder;
  };
  [[nodiscard]] Loaded take(const Surface& surface, const std::string& backend) const;
  void keep(Loaded loaded) const;

  mutable std::mutex mutex_;
  mutable Loaded loaded_;
};

}  // namespace isimp
