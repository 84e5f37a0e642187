#include "isimp/parallel/backend.h"

#include "devices.h"
#include "isimp/core/errors.h"

namespace isimp::parallel {
namespace {

/// What keeps CUDA from working, looked up once: a driver does not come or go while the program runs.
const std::string& obstacle() {
  static const std::string found = cuda_obstacle();
  return found;
}

std::string listed(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

}  // namespace

std::vector<std::string> backends() {
  std::vector<std::string> names{"cpu"};
  if (obstacle().empty()) names.emplace_back("cuda");
  return names;
}

const Kernels& backend(std::string_view name) {
  if (name == "cpu") return cpu_kernels();
  if (name == "cuda" && obstacle().empty()) return cuda_kernels();
  const std::string there_is = "; there is: " + listed(backends());
  if (name == "cuda") throw InvalidInput("back end 'cuda' is not available here: " + obstacle() + there_is);
  throw InvalidInput("unknown back end '" + std::string(name) + "'" + there_is);
}

}  // namespace isimp::parallel
