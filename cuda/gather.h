#pragma once

#include <cstdint>

/// The gathering of a queue on devices on which each source reserves its places at once. The including header defines
/// for_all and reserve.
namespace isimp::parallel::ISIMP_DEVICE {

/// Raises a number that other threads raise too.
/// \param more  in [0, 3]
/// \return the number before
ISIMP_KERNEL inline std::int32_t reserve(std::int32_t& number, std::int32_t more);

template <class Source>
struct Gather {
  Source source;
  ISIMP_KERNEL void operator()(std::int64_t i) const {
    const auto& flood = source.flood;
    const std::int32_t bits = source.bits(i);
    const std::int32_t at = reserve(flood.progress->size[source.step % 3], flood.number(bits));
    flood.add(source.face(i), bits, source.step, at);
  }
};

template <class Source>
void gather(const Source& source, std::int64_t count) {
  for_all(std::int64_t{0}, count, Gather<Source>{source});
}

}  // namespace isimp::parallel::ISIMP_DEVICE
