// Friction of pads whose taxels are tips of pillars: each friction of the grid follows the pad with a bed of
// its own, and a frame takes weight from those whose pillars would carry something else (docs/methods.md
// §29.5). Estimate thread; fixed memory, nothing allocates.
#pragma once

#include "core/friction/friction_filter.hpp"
#include "core/friction/pillar_beds.hpp"

namespace slipd {

class FrictionByPillars final : public FrictionFilter {
 public:
  // Throws std::invalid_argument as PillarBeds does.
  FrictionByPillars(const TaxelLayout& layout, const FrictionPrior& prior,
                    const FrictionFilterOptions& options = {});

  void update(const FrictionFrame& frame) noexcept override;
  void reset() noexcept override;
  void lose_sight() noexcept override;
  // Each pillar is off by its own stiffness, which is the same in all frames.
  double common_sigma(const ContactPatch& patch) const noexcept override;

 protected:
  void lose_history(HistoryEvent why) noexcept override;

 private:
  void weigh_frame() noexcept;

  PillarBeds beds_;
};

}  // namespace slipd
