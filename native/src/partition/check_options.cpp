#include "check_options.h"

#include <cmath>
#include <sstream>
#include <string>

#include "isimp/core/errors.h"
#include "isimp/parallel/backend.h"

namespace isimp {
namespace {

template <class T>
[[noreturn]] void out_of_range(const char* name, const std::string& range, T value) {
  std::ostringstream text;
  text << name << " must be " << range << ", got " << value;
  throw InvalidInput(text.str());
}

/// How many of the ways to choose the number of regions are taken; more than one contradict each other.
void check_count(const Surface& surface, const PartitionOptions& options) {
  std::string given;
  const auto note = [&](bool is, const char* name) {
    if (is) given += (given.empty() ? "" : " and ") + std::string(name);
  };
  note(options.proxies.has_value(), "proxies");
  note(options.detail.has_value(), "detail");
  note(options.tolerance.has_value(), "tolerance");
  note(options.bound.has_value(), "bound");
  if (given.find(' ') != std::string::npos)
    throw InvalidInput(given + " are given, but each alone says how many regions there will be: give one of them");
  const auto positive = [](double x) { return x > 0 && std::isfinite(x); };
  if (options.proxies && (*options.proxies < 1 || *options.proxies > surface.face_count()))
    out_of_range("proxies", "in [1, " + std::to_string(surface.face_count()) + "]", *options.proxies);
  if (options.detail && !(*options.detail > 0 && *options.detail <= 1))
    out_of_range("detail", "in (0, 1]", *options.detail);
  if (options.tolerance && !positive(*options.tolerance))
    out_of_range("tolerance", "a finite length above 0", *options.tolerance);
  if (options.bound && !positive(*options.bound)) out_of_range("bound", "a finite length above 0", *options.bound);
  if (options.bound && options.method != Method::hierarchy)
    throw InvalidInput("a bound is kept by method hierarchy only");
  if (options.noise && !positive(*options.noise) && *options.noise != 0)
    out_of_range("noise", "a finite length, at least 0", *options.noise);
}

}  // namespace

void check(const Surface& surface, const PartitionOptions& options) {
  check_count(surface, options);
  if (!(options.leave_out >= 0 && options.leave_out < 1)) out_of_range("leave_out", "in [0, 1)", options.leave_out);
  if (!(options.adaptivity >= 0 && options.adaptivity <= 1))
    out_of_range("adaptivity", "in [0, 1]", options.adaptivity);
  if (options.iterations < 1) out_of_range("iterations", "at least 1", options.iterations);
  if (options.threads < 0) out_of_range("threads", "at least 0", options.threads);
  if (options.nearest < 1 || options.nearest > parallel::Flooder::kMostNearest)
    out_of_range("nearest", "in [1, " + std::to_string(parallel::Flooder::kMostNearest) + "]", options.nearest);
  if (!(options.fraction > 0 && options.fraction <= 1)) out_of_range("fraction", "in (0, 1]", options.fraction);
  if (options.backend != "cpu") (void)parallel::backend(options.backend);
}

}  // namespace isimp
