// What a gripper is ordered to do. Plain values; any thread.
#pragma once

#include <cstdint>

namespace slipd::grip {

enum class Move : std::uint8_t { stay, open, grip };

struct Order {
  Move move = Move::stay;
  // Of each finger, N; of Move::grip.
  double force_n = 0;
  bool operator==(const Order&) const = default;
};

}  // namespace slipd::grip
