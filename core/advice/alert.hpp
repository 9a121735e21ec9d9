// From a margin to a level that a controller may act on: thresholds, hysteresis, a least duration; and from
// its course how long until slip. Estimate thread; plain state, nothing allocated.
#pragma once

#include <cstdint>
#include <optional>

#include "core/estimate/estimate.hpp"
#include "core/estimate/settings.hpp"

namespace slipd {

// How many standard deviations are taken off a margin so that an alert is raised where silence would cost
// more: where the probability that the margin is below the threshold, times `cost`, exceeds that it is not.
// The error of a margin is Gaussian. cost: of a slip that is not told, in needless alerts; > 0, below 1 more
// is put on than taken off.
double sigmas_for(double cost) noexcept;
// The cost at which so many are taken off.
double cost_of(double sigmas) noexcept;

class AlertLogic {
 public:
  explicit AlertLogic(const AlertSettings& settings)
      : settings_(settings), sigmas_(sigmas_for(settings.cost)) {}

  // gamma less sigmas_for(AlertSettings::cost) times sigma decides, or gamma_low (AlertSettings::use). A
  // level is raised by the first sample at which the margin has stayed below its threshold for min_ms, and
  // lowered when it has stayed above threshold + hysteresis for as long, or when contact is lost. A margin
  // that is not known raises nothing and lowers nothing: who does not know has no evidence that the grip got
  // safer. Such samples do not count towards min_ms. A level whose margin is gone ends once the object has
  // been seen not to slide for kStillNs: what it foretold has not come. No alert is `unknown` from
  // kNoneHoldsNs after the last sample on that could have raised one: with a margin, without contact, or
  // `watched`: slides of the object show otherwise.
  Alert update(std::int64_t time_ns, const Estimate& now, bool watched = false) noexcept;

  // The same of `out`, whose margin and sliding are decided, written into its alert and cause. An object that
  // is seen to slide is a slip whatever the margin.
  void judge(Estimate& out) noexcept;

  // How long `none` holds after the last sample that could have raised an alert, ns. Shorter: an alert
  // flickers between none and unknown where margins come now and then. Longer: none is said by what sees
  // nothing.
  static constexpr std::int64_t kNoneHoldsNs = 200'000'000;
  // How long the object has to be seen not to slide for a level without a margin to end, ns; samples that do
  // not show it do not count. Shorter: an alert ends between two margins of a grip that slips. Longer: an
  // alert stands when what raised it is long gone. It is some times the time that a slide takes to show
  // (methods.md §30), and was set before any recording was looked at with it.
  static constexpr std::int64_t kStillNs = 1'000'000'000;

 private:
  Alert level_after(std::int64_t time_ns, double margin) noexcept;
  void watch_unsupported(std::int64_t passed_ns, const Estimate& now) noexcept;

  // How long a condition has held; only time between samples that show it counts.
  class Stopwatch {
   public:
    void restart() noexcept { since_ns_ = -1; }
    void pause(std::int64_t for_ns) noexcept;
    bool has_run(bool condition, std::int64_t now_ns, std::int64_t least_ns) noexcept;

   private:
    std::int64_t since_ns_ = -1;
  };

  AlertSettings settings_;
  double sigmas_;                           // taken off the margin
  Alert level_ = Alert::none;               // never unknown
  std::optional<std::int64_t> watched_ns_;  // the last sample that could have raised an alert
  Stopwatch below_warn_, below_slip_, above_;
  std::int64_t still_ns_ = 0;  // without a margin, for which the object was seen not to slide
  std::int64_t last_ns_ = 0;
};

// Checked by tests/core/advice/alert_test.cpp, over whole grasps with tests/bench/alert_statistics.cpp.
struct SlipForecastOptions {
  // Time after which a sample weighs 1/e; s, 0.001 … 1. Too small: noise is taken for a fall, and slow
  // sensors have no forecast. Too large: a fall is seen late.
  double forget_s = 0.02;
  // Share of a margin's variance that samples do not have in common, the floor of their scatter about the
  // line; 0 … 1. Too small: a smooth error of the margin is taken for a fall. Too large: no forecast.
  double independent_share = 0.01;
};

// The margin's slope by least squares with exponential forgetting.
class SlipForecast {
 public:
  explicit SlipForecast(const SlipForecastOptions& options = {}) noexcept : options_(options) {}

  // Seconds until gamma reaches 0 as it falls now; nullopt when it does not clearly fall. Samples in order of
  // time.
  std::optional<double> update(std::int64_t time_ns, std::optional<double> gamma, double sigma) noexcept;

 private:
  const SlipForecastOptions options_;
  std::int64_t last_ns_ = 0;
  // Sums over the samples, of 1, of time before the newest, of gamma and of their products.
  double weight_ = 0, t_ = 0, g_ = 0, tt_ = 0, tg_ = 0, gg_ = 0;
};

struct GripAdvice {
  std::optional<double> increase_n;  // 0: the grip is as good as it should be
  std::optional<double> sigma_n;     // standard deviation, of what is lacking or to spare
};

// The normal force in N that is lacking for `target_margin` (docs/theory.md §1.2): Q/(mu (1 - target)) - P,
// at least 0. Its sigma is that of friction and of Q; a friction_sigma of nullopt counts as 0. Nothing is
// said without friction.
GripAdvice grip_advice(double normal_n, double shear_n, double shear_sigma_n, std::optional<double> friction,
                       std::optional<double> friction_sigma, double target_margin) noexcept;

// Writes it into `out`, whose forces and friction are set, for the pull that is as near to slip as force and
// torque together. A torque that grows with the grip's radius is held at the present one: the safe side.
void advise(Estimate& out, double pull_sigma_n, double target_margin) noexcept;

}  // namespace slipd
