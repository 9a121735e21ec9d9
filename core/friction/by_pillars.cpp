#include "core/friction/by_pillars.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slipd {

FrictionByPillars::FrictionByPillars(const TaxelLayout& layout, const FrictionPrior& prior,
                                     const FrictionFilterOptions& options)
    : FrictionFilter(prior, options.foundations, options), beds_(layout, grid().frictions()) {}

void FrictionByPillars::reset() noexcept {
  reset_evidence();
  beds_.clear();
}

// What each pillar carries is sensed, so that only which of them slip is not known.
void FrictionByPillars::lose_sight() noexcept {
  reset();
  beds_.lose_history();
}

void FrictionByPillars::lose_history(HistoryEvent /*why*/) noexcept {
  posterior_.reset();
  beds_.lose_history();
}

double FrictionByPillars::common_sigma(const ContactPatch& patch) const noexcept {
  return beds_.uneven_share() / std::sqrt(static_cast<double>(std::max<std::size_t>(patch.count, 1)));
}

void FrictionByPillars::update(const FrictionFrame& frame) noexcept {
  const ContactPatch& patch = frame.patch;
  begin_frame(frame);
  bound_by_held();
  beds_.follow(patch, frame.step.seconds());
  weigh_frame();
  posterior_.conclude();
}

// The signed root of a misfit above the least one is a residual in units of its noise. Nearly all of that is
// by uneven pillars, which are the same in all frames.
void FrictionByPillars::weigh_frame() noexcept {
  double least = std::numeric_limits<double>::infinity();
  std::size_t best = 0;
  for (std::size_t j = 0; j < grid().count(); ++j) {
    if (!(beds_.misfit(j) < least)) continue;
    least = beds_.misfit(j);
    best = j;
  }
  constexpr double kComponents = 2;
  if (!explain(least / (kComponents * static_cast<double>(std::max<std::size_t>(beds_.touching(), 1))), true))
    return;
  PerFriction residuals;  // the first grid().count() of them
  for (std::size_t j = 0; j < grid().count(); ++j)
    residuals[j] =
        std::copysign(std::sqrt(beds_.misfit(j) - least), grid().friction(j) - grid().friction(best));
  constexpr double kCommon = 1, kNoise = 1;
  posterior_.weigh(Evidence::margin, residuals, kCommon, kNoise);
}

}  // namespace slipd
