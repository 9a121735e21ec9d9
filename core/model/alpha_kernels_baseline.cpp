// The loops of alpha_kernels.ipp for the instruction set that every processor of its kind has.
#include "core/model/alpha_kernels.ipp"

namespace slipd {
extern const AlphaKernels kAlphaKernels_baseline;
const AlphaKernels kAlphaKernels_baseline{"baseline", frame, ratio, angles, project};
}  // namespace slipd
