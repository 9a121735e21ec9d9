// The taxels that a data set has rows for: all of a layout's, or one an orbit where they are folded
// (fold.hpp).
#pragma once

#include <vector>

#include "core/frame/layout.hpp"
#include "paper/dataset/fold.hpp"

namespace slipd {

struct TaxelSet {
  std::vector<double> x_m, y_m;
  std::vector<float> weight;  // by which a row is multiplied; empty: 1
  double side_m = 0;

  explicit TaxelSet(const TaxelLayout& layout)
      : x_m(layout.x_m().begin(), layout.x_m().end()),
        y_m(layout.y_m().begin(), layout.y_m().end()),
        side_m(layout.side_m()) {}

  TaxelSet(const TaxelLayout& layout, const Fold& folded) : weight(folded.weight), side_m(layout.side_m()) {
    for (const std::size_t taxel : folded.representative) {
      x_m.push_back(layout.x_m()[taxel]);
      y_m.push_back(layout.y_m()[taxel]);
    }
  }

  std::size_t size() const noexcept { return x_m.size(); }
};

}  // namespace slipd
