// What the registered estimator sees of a contact: it is found in the frame, brought into a standard frame
// (docs/methods.md §21) by its centre and radius, and summed over rings. Place, size, stiffness and force
// drop out; friction and margin are left.
#pragma once

#include "core/frame/layout.hpp"
#include "core/patch/rings.hpp"
#include "paper/dataset/contact_columns.hpp"

namespace slipd {

// What a ring's alpha is multiplied by, so that noise is alike on all (docs/methods.md §21.3): by the taxels
// that it holds, few in the middle, and by the pressure on them, little at the rim. Relative.
double ring_weight(std::size_t ring, std::size_t rings) noexcept;

// The same contact on fewer rings, each of neighbouring ones added up. count divides Rings::kCount.
Rings merged(const Rings& rings, std::size_t count) noexcept;

// alpha of each of the first `count` rings in rad, atan(sum q / sum p), times its weight; 0 for a ring
// without taxels. Any thread.
std::array<float, Rings::kCount> ring_angles(const Rings& rings, std::size_t count) noexcept;

class RingColumns final : public ContactColumns {
 public:
  // Noise as in FrameColumns, on all taxels. A contact that the sensor does not notice gives a column of
  // zeros.
  RingColumns(TaxelLayout layout, Scene scene, std::uint64_t seed, const FrameChoice& choice,
              std::size_t rings = Rings::kCount);

  std::size_t rows() const noexcept override { return rings_; }
  void fill(std::size_t first, std::size_t count, float* out) const override;

 private:
  TaxelLayout layout_;
  std::size_t rings_;
};

}  // namespace slipd
