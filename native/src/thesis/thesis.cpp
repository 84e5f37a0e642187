#include "isimp/thesis/thesis.h"

#include <memory>
#include <mutex>
#include <utility>

#include "hybrid.h"
#include "isimp/parallel/backend.h"
#include "kept_flooder.h"
#include "rounds.h"

namespace isimp {

/// The decimated mesh of the latest surface.
class KeptDecimated {
 public:
  /// Null where it is not kept.
  std::shared_ptr<const Decimated> find(const Surface& surface, double fraction) {
    const std::lock_guard lock(mutex_);
    return decimated_ && graph_ == &surface.graph() && decimated_->fraction == fraction ? decimated_ : nullptr;
  }

  void keep(const Surface& surface, std::shared_ptr<const Decimated> decimated) {
    const std::lock_guard lock(mutex_);
    guided_ = surface.guided();
    graph_ = &surface.graph();
    decimated_ = std::move(decimated);
  }

 private:
  std::mutex mutex_;
  std::shared_ptr<const GuidedGraph> guided_;  // owns the graph, unless the mesh does
  const FaceGraph* graph_ = nullptr;
  std::shared_ptr<const Decimated> decimated_;
};

namespace {

Partition on_decimated(const Surface& surface, KeptDecimated& kept, const PartitionOptions& options, Job& job) {
  std::shared_ptr<const Decimated> decimated = kept.find(surface, options.fraction);
  double done = 0.0;
  if (!decimated) {
    done = 0.9;
    const Job::Stage stage(job, "decimating", 0.0, done);
    decimated = std::make_shared<const Decimated>(decimate(surface, options.fraction, job));
    kept.keep(surface, decimated);
  }
  const Job::Stage stage(job, "partitioning", done, 1.0);
  return hybrid(surface, *decimated, options, job);
}

}  // namespace

struct Thesis::Kept {
  KeptFlooder flooder;
  KeptDecimated decimated;
};

Thesis::Thesis() : kept_(std::make_unique<Kept>()) {}

Thesis::~Thesis() = default;

bool Thesis::is_built() { return true; }

void Thesis::check(const PartitionOptions& options) {
  if (options.backend != "cpu") (void)parallel::backend(options.backend);
}

Partition Thesis::by_number(const Surface& surface, const Hierarchy& hierarchy, const PartitionOptions& options,
                            Job& job) const {
  if (options.method == Method::hybrid) return on_decimated(surface, kept_->decimated, options, job);
  if (!needs_flooder(options)) return in_rounds(surface, hierarchy, nullptr, options, job);
  return kept_->flooder.with(surface, options.backend, [&](parallel::Flooder& flooder) {
    return in_rounds(surface, hierarchy, &flooder, options, job);
  });
}

std::vector<std::string> backends() { return parallel::backends(); }

}  // namespace isimp
