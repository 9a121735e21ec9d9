// How a field of displacements over a regular grid bends: its second differences along rows and columns. They
// are 0 for every rigid motion of the gel's picture and for every even stretch, so that they need no place of
// rest (docs/displacement.md). Estimate thread; allocates in its constructor only.
#pragma once

#include <span>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"

namespace slipd {

class FieldBends {
 public:
  // Throws std::invalid_argument unless the layout is a grid of at least kLeast points each way.
  explicit FieldBends(const TaxelLayout& layout);
  static constexpr std::size_t kLeast = 3;

  // Number of values: two, along x and y, for each point that has both neighbours in its row, and the same
  // for columns.
  std::size_t size() const noexcept { return values_.size(); }
  // Of a frame of SensorClass::displacement, mm. Where one of the three points is not seen the last value
  // stands.
  std::span<const float> update(const Frame& frame) noexcept;

 private:
  void take(const Frame& frame, std::size_t middle, std::size_t step) noexcept;

  TaxelLayout::Grid grid_;
  std::vector<float> values_;
  std::size_t next_ = 0;
};

}  // namespace slipd
