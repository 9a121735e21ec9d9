// What the estimator will see, for training: simulated frames (exact averages over each taxel, noise on
// pressure and on shear) taken through the same mask and the same angle as real ones.
#pragma once

#include "core/model/column_source.hpp"
#include "core/model/dataset.hpp"
#include "core/model/taxel_set.hpp"

namespace slipd {

// Which contacts of the scene's endless row of them, under which loads.
struct FrameChoice {
  std::size_t first_contact = 0;
  DataSetSize size;
  bool random_loads = false;  // Gamma uniform in [0, 1) instead of in even steps
};

class FrameColumns final : public ColumnSource {
 public:
  // Column j is contact first_contact + j / loads under load j % loads, as alpha in rad. Noise: uniform
  // within the scene's fraction of the frame's largest pressure on the pressures, of its largest shear on the
  // shears. Throws std::invalid_argument for a noisy or off-centre scene on folded taxels.
  FrameColumns(TaxelSet taxels, Scene scene, std::uint64_t seed, FrameChoice choice);

  std::size_t rows() const noexcept override { return taxels_.size(); }
  std::size_t columns() const noexcept override { return choice_.size.columns(); }
  void fill(std::size_t first, std::size_t count, float* out) const override;

  double gamma(std::size_t column) const;
  double friction(std::size_t column) const;

 private:
  std::size_t contact(std::size_t column) const noexcept {
    return choice_.first_contact + column / choice_.size.loads;
  }

  TaxelSet taxels_;
  Scene scene_;
  std::uint64_t seed_;
  FrameChoice choice_;
};

}  // namespace slipd
