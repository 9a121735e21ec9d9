// The loops of disc_kernels.ipp for x86-64 with AVX2 and FMA; built with flags of its own, see
// CMakeLists.txt.
#include "core/patch/disc_kernels.ipp"

namespace slipd {
extern const DiscKernels kDiscKernels_avx2;
const DiscKernels kDiscKernels_avx2{"avx2", noise, place, weigh, force, shear_squares, moments, rings};
}  // namespace slipd
