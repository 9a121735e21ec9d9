// The loops of packed_kernels.ipp for the instruction set that every processor of its kind has.
#include "core/model/packed_kernels.ipp"

namespace slipd {
extern const PackedKernels kPackedKernels_baseline;
const PackedKernels kPackedKernels_baseline{"baseline", project, add_product};
}  // namespace slipd
