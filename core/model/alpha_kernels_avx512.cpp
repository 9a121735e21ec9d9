// The loops of alpha_kernels.ipp for x86-64 with AVX-512; built with flags of its own, see CMakeLists.txt.
#include "core/model/alpha_kernels.ipp"

namespace slipd {
extern const AlphaKernels kAlphaKernels_avx512;
const AlphaKernels kAlphaKernels_avx512{"avx512", frame, ratio, angles, project};
}  // namespace slipd
