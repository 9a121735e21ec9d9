// What MCAP files can fail with.
#pragma once

#include <stdexcept>

namespace slipd::ros2 {

// what() is `FILE: what is wrong`.
class McapError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace slipd::ros2
