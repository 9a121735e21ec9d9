// What the estimator will see, for training: simulated frames (exact averages over each taxel, noise on
// pressure and on shear) taken through the same mask and the same angle as real ones.
#pragma once

#include "paper/dataset/contact_columns.hpp"
#include "paper/dataset/taxel_set.hpp"

namespace slipd {

class FrameColumns final : public ContactColumns {
 public:
  // Values: alpha in rad. Noise: uniform
  // within the scene's fraction of the frame's largest pressure on the pressures, of its largest shear on the
  // shears. Throws std::invalid_argument for a noisy or off-centre scene on folded taxels.
  FrameColumns(TaxelSet taxels, Scene scene, std::uint64_t seed, const FrameChoice& choice);

  std::size_t rows() const noexcept override { return taxels_.size(); }
  void fill(std::size_t first, std::size_t count, float* out) const override;

 private:
  TaxelSet taxels_;
};

}  // namespace slipd
