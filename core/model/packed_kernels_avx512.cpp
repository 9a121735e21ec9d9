// The loops of packed_kernels.ipp for x86-64 with AVX-512; built with flags of its own, see CMakeLists.txt.
#include "core/model/packed_kernels.ipp"

namespace slipd {
extern const PackedKernels kPackedKernels_avx512;
const PackedKernels kPackedKernels_avx512{"avx512", project, add_product};
}  // namespace slipd
