// What the tests of friction filters have in common: a filter with its path, and frames of forces only.
#pragma once

#include <cstdint>

#include "core/friction/friction_filter.hpp"
#include "core/load/load_path.hpp"

namespace slipd::friction_filter {

inline constexpr FrictionPrior kFilterPrior{.expected = {0.1, 0.9}, .spread = 0.15};

// A filter with the path that its pipeline follows.
template <class Filter>
class Followed {
 public:
  explicit Followed(const FrictionPrior& prior, const FrictionFilterOptions& options = {})
      : filter_(prior, options) {}
  void update(std::int64_t time_ns, const ContactPatch& patch, const Reading* reading,
              const SlidingVerdict& previous = {}) {
    const bool under_torque = reading != nullptr && reading->under_torque;
    filter_.update({patch, path_.follow(load_of(time_ns, patch, patch, under_torque)), reading, previous});
  }
  void reset() {
    filter_.reset();
    path_.forget();
  }
  Filter* operator->() { return &filter_; }
  const Filter* operator->() const { return &filter_; }

 private:
  Filter filter_;
  LoadPath path_;
};

// A frame with forces only, N.
inline ContactPatch forces(double normal_n, double shear_n) {
  ContactPatch patch;
  patch.in_contact = true;
  patch.normal_n = normal_n;
  patch.shear_n = patch.shear_x_n = shear_n;
  patch.normal_sigma_n = patch.shear_sigma_n = 0.001;
  return patch;
}

}  // namespace slipd::friction_filter
