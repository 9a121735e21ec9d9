// What a user may choose about estimation. Plain values, checked by the configuration's schema.
#pragma once

#include <cstdint>

namespace slipd {

enum class MethodChoice : std::uint8_t { automatic, svd_knn, registered, moments, fit };

struct EstimatorSettings {
  MethodChoice method = MethodChoice::automatic;
  double budget_us = 50;    // for `automatic`: time per frame
  int rank = 8;             // SVD bases kept
  int neighbours = 5;       // k of KNN
  bool tracking = true;     // false: each frame for itself
  double sigma_max = 0.15;  // above it an estimate means nothing: state learning
  bool operator==(const EstimatorSettings&) const = default;
};

struct AlertSettings {
  double warn_below = 0.4;
  double slip_below = 0.2;
  double hysteresis = 0.05;
  double min_ms = 2;
  double sigmas = 1;  // how many sigma are taken off gamma before it is compared
  double target_margin = 0.5;
  double false_alarms_per_hour = 1;  // of the detection of sliding in a held grasp, by design
  bool operator==(const AlertSettings&) const = default;
};

}  // namespace slipd
