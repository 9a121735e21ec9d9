// Random numbers one after the other, where each is drawn once.
#pragma once

#include <cstdint>

#include "core/numeric/random.hpp"

namespace lab {

class Draws {
 public:
  explicit Draws(const slipd::RandomStream& stream) : stream_(stream) {}
  // From low to high.
  double uniform(double low, double high) { return stream_.uniform(next_++, low, high); }
  // 0 … count - 1.
  int below(int count) { return static_cast<int>(stream_.uniform(next_++) * count); }

 private:
  slipd::RandomStream stream_;
  std::uint64_t next_ = 0;
};

}  // namespace lab
