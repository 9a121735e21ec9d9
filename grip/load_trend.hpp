// How fast the load on the fingers grows. One thread's own.
#pragma once

#include <cstdint>
#include <deque>

namespace slipd::grip {

class LoadTrend {
 public:
  // span_s: of the samples that show it, > 0. Too small: noise hides growth. Too large: a lift is seen late.
  explicit LoadTrend(double span_s) : span_s_(span_s) {}

  // The shear force at this time, N, in order of time; NaN: not known.
  void add(std::int64_t time_ns, double shear_n);

  // By what factor the load will have grown in so many seconds, >= 1, along the straight line through the
  // samples: with its slope less three standard deviations, so that noise is no growth.
  double growth(double ahead_s) const;

 private:
  struct Sample {
    std::int64_t time_ns;
    double shear_n;
  };

  const double span_s_;
  std::deque<Sample> samples_;
};

}  // namespace slipd::grip
