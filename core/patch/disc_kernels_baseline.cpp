// The loops of disc_kernels.ipp for the instruction set that every processor of its kind has.
#include "core/patch/disc_kernels.ipp"

namespace slipd {
extern const DiscKernels kDiscKernels_baseline;
const DiscKernels kDiscKernels_baseline{"baseline", noise,         place,   weigh,
                                        force,      shear_squares, moments, rings};
}  // namespace slipd
