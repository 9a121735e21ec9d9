// The loops of packed_kernels.ipp for x86-64 with AVX2 and FMA; built with flags of its own, see
// CMakeLists.txt.
#include "core/model/packed_kernels.ipp"

namespace slipd {
extern const PackedKernels kPackedKernels_avx2;
const PackedKernels kPackedKernels_avx2{"avx2", project, add_product};
}  // namespace slipd
