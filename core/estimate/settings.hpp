// What a user may choose about estimation. Plain values, checked by the configuration's schema.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "core/contact/scene.hpp"

namespace slipd {

enum class MethodChoice : std::uint8_t { automatic, svd_knn, registered, moments, fit, closing, block_fit };

// By their names in slipd.json: auto, moments, fit, … Set-up.
const std::map<std::string, MethodChoice>& method_choices();

struct EstimatorSettings {
  MethodChoice method = MethodChoice::automatic;
  // For `automatic`: time per frame, us, > 0; none: frame_budget_us (core/chain/setup/method_table.hpp).
  std::optional<double> budget_us = std::nullopt;
  int rank = 8;             // SVD bases kept
  int neighbours = 5;       // k of KNN
  bool tracking = true;     // false: each frame for itself
  double sigma_max = 0.15;  // above it an estimate means nothing: state learning
  bool operator==(const EstimatorSettings&) const = default;
};

// Friction of one sensor's contact, known beforehand: a value, or a range that it lies in.
struct KnownFriction {
  // A value; > 0.
  KnownFriction(double value) : range{value, value} {}  // NOLINT(google-explicit-constructor)
  // 0 < low <= high.
  KnownFriction(Range between) : range(between) {}  // NOLINT(google-explicit-constructor)
  // mu; both ends are equal if it is a value.
  Range range;
  // Whether it is a value.
  bool is_value() const noexcept { return range.low == range.high; }
  bool operator==(const KnownFriction&) const = default;
};

// What alerts are judged by.
enum class AlertUse : std::uint8_t {
  margin,  // Gamma less sigmas_for(cost) times its sigma; nothing while Gamma is not known
  low      // gamma_low: also before friction is known
};

struct ContactSettings {
  // P below which the sensor is not in contact, N, >= 0; none: default_min_normal_n of its layout
  // (core/patch/contact_gate.hpp).
  std::optional<double> min_normal_n;
  bool operator==(const ContactSettings&) const = default;
};

struct AlertSettings {
  double warn_below = 0.4;
  double slip_below = 0.2;
  double hysteresis = 0.05;
  double min_ms = 2;
  double cost = 5;  // what a slip that is not told costs, in needless alerts; 1 …
  double target_margin = 0.5;
  double false_alarms_per_hour = 1;  // of the detection of sliding in a held grasp, by design
  AlertUse use = AlertUse::margin;
  bool operator==(const AlertSettings&) const = default;
};

}  // namespace slipd
