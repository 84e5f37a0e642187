// The kernels once more, for the device that disturbs.
#define ISIMP_DEVICE on_chaos
#define ISIMP_DEVICE_HEADER "chaos/device_chaos.h"
#include "kernels.cu"

namespace isimp::chaos {

const parallel::Kernels& kernels() { return parallel::on_chaos::device_kernels(); }

}  // namespace isimp::chaos
