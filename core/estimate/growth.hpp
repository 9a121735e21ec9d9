// What the last growth of the contact left at its rim. Where both forces grow together and nothing slips, the
// new ring carries q/p = dQ/dP: as even as a slip zone, and not to be taken for one.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

namespace slipd {

class Growth {
 public:
  // Estimate thread; in order of time.
  void update(std::int64_t time_ns, double normal_n, double shear_n) noexcept {
    if (normal_n > (1 + kNoticed) * peak_n_) {  // growing
      peak_n_ = normal_n;
      grew_ns_ = time_ns;
      slope_ = std::fabs(shear_n - start_shear_n_) / (normal_n - start_normal_n_);
    } else if (normal_n < (1 - 3 * kNoticed) * peak_n_) {  // the ring has left the contact again
      start(normal_n, shear_n);
      slope_.reset();
    } else if (time_ns - grew_ns_ > kOver_ns) {  // over: a later growth starts here
      start(normal_n, shear_n);
      peak_n_ = normal_n > peak_n_ ? normal_n : peak_n_;
    }
  }

  void reset() noexcept {
    start(0, 0);
    slope_.reset();
  }

  // Whether q/p = ratio at the rim may come from the growth and not from slip.
  bool explains(double ratio, double sigma) const noexcept {
    return slope_ && std::fabs(std::fabs(ratio) - *slope_) < 3 * sigma + kLike * std::fabs(ratio);
  }

 private:
  static constexpr double kNoticed = 0.01;  // of the force
  static constexpr double kLike = 0.05;     // relative
  static constexpr std::int64_t kOver_ns = 50'000'000;

  void start(double normal_n, double shear_n) noexcept {
    start_normal_n_ = peak_n_ = normal_n;
    start_shear_n_ = shear_n;
  }

  double start_normal_n_ = 0, start_shear_n_ = 0, peak_n_ = 0;
  std::int64_t grew_ns_ = 0;
  std::optional<double> slope_;
};

}  // namespace slipd
