// Values of which the middle one and others by rank are wanted: errors, times, delays.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/frame/frame.hpp"

namespace lab {

class Samples {
 public:
  void add(double value) { values_.push_back(value); }
  void add(const Samples& other) {
    values_.insert(values_.end(), other.values_.begin(), other.values_.end());
  }

  // The middle value, of two the larger one; NaN without values.
  double median() const { return ranked(values_.size() / 2); }
  // The value that this share of the others, 0 … 1, lies below; NaN without values.
  double quantile(double share) const {
    return values_.empty()
               ? slipd::kUnknown
               : ranked(static_cast<std::size_t>(share * static_cast<double>(values_.size() - 1)));
  }

 private:
  double ranked(std::size_t rank) const {
    if (values_.empty()) return slipd::kUnknown;
    std::vector<double> values = values_;
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
    std::nth_element(values.begin(), at, values.end());
    return *at;
  }

  std::vector<double> values_;
};

}  // namespace lab
