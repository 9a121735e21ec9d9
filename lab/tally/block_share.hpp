// A share of frames with the error that it has because frames of one grasp are alike: grasps are drawn,
// frames are not.
#pragma once

#include <cmath>
#include <vector>

#include "core/frame/frame.hpp"

namespace lab {

class BlockShare {
 public:
  // A block, such as a grasp: so many of its frames, and of how many.
  void add(double counted, double of) { blocks_.push_back({counted, of}); }

  // NaN of no frames.
  double share() const noexcept {
    const Block all = sum();
    return all.of > 0 ? all.counted / all.of : slipd::kUnknown;
  }

  // Its standard deviation: that of a ratio of two sums over blocks, to first order (Cochran, Sampling
  // Techniques, 3rd edition, 1977, eq. 2.39, of an infinite population). NaN of less than two blocks.
  double sigma() const noexcept {
    const Block all = sum();
    const double count = static_cast<double>(blocks_.size()), share = this->share();
    if (blocks_.size() < 2 || !(all.of > 0)) return slipd::kUnknown;
    double square = 0;
    for (const Block& block : blocks_) square += std::pow(block.counted - share * block.of, 2);
    return std::sqrt(square * count / (count - 1)) / all.of;
  }

 private:
  struct Block {
    double counted = 0, of = 0;
  };
  Block sum() const noexcept {
    Block all;
    for (const Block& block : blocks_) {
      all.counted += block.counted;
      all.of += block.of;
    }
    return all;
  }

  std::vector<Block> blocks_;
};

}  // namespace lab
