#include "isimp/parallel/backend.h"

#include <iomanip>
#include <sstream>
#include <string>

#include "devices.h"
#include "isimp/core/errors.h"

namespace isimp::parallel {
namespace {

/// The reason why CUDA does not work, found once: drivers do not change while the program runs.
const std::string& obstacle() {
  static const std::string found = cuda_obstacle();
  return found;
}

std::string listed(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

std::string megabytes(std::size_t bytes) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(bytes < 10'000'000 ? 3 : 0) << static_cast<double>(bytes) / 1e6 << " MB";
  return text.str();
}

std::string failed(std::string_view backend, std::string_view doing, std::size_t faces, const std::string& reason) {
  std::ostringstream text;
  text << doing << ' ' << faces << " faces on back end '" << backend << "' " << reason;
  if (backend != "cpu") text << "; back end 'cpu' can do the same in main memory, with the same result";
  return text.str();
}

}  // namespace

std::string out_of_memory(std::string_view backend, std::string_view doing, std::size_t faces, std::size_t wanted,
                          std::size_t held) {
  return failed(backend, doing, faces,
                "ran out of memory: " + megabytes(wanted) + " more were wanted, with " + megabytes(held) + " held");
}

std::string out_of_order(std::string_view backend, std::string_view doing, std::size_t faces, std::string_view reason) {
  return failed(backend, doing, faces, "failed: " + std::string(reason));
}

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
