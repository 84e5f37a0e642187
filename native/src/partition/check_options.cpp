#include "check_options.h"

#include <string>

#include "isimp/core/errors.h"
#include "isimp/core/options.h"

namespace isimp {
namespace {

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
  if (options.proxies && (*options.proxies < 1 || *options.proxies > surface.face_count()))
    throw InvalidInput("proxies must be in [1, " + std::to_string(surface.face_count()) + "], got " +
                       std::to_string(*options.proxies));
  if (options.bound && options.method != Method::hierarchy)
    throw InvalidInput("a bound is kept by method hierarchy only");
}

}  // namespace

void check(const Surface& surface, const PartitionOptions& options) {
  check_count(surface, options);
  check_fields(options);
}

}  // namespace isimp
