// All registers as of now, from slipd's board in shared memory, without waiting for slipd: while there is no
// board, or slipd gives no signs of life, they say so. One thread's own: that of the loop.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bridges/modbus/board_finder.hpp"
#include "bridges/modbus/register_map.hpp"

namespace slipd::modbus {

class LiveRegisters {
 public:
  // `blocks`: names of the blocks; empty: slipd's sensors, then its grasps. Estimates that are older than
  // max_age_s are stale.
  LiveRegisters(bridges::Loop& loop, const std::string& socket, std::vector<std::string> blocks,
                double max_age_s);

  // Fills kRegisters registers.
  void write(std::span<std::uint16_t> registers);
  // Whether slipd gives signs of life; if not, another board is looked for.
  bool alive();

 private:
  void take(FoundBoard&& board);
  void tell_unknown(const bridges::Inventory& all);
  void go_away(const std::string& why);

  std::vector<std::string> names_;  // of the blocks
  bool names_are_slipds_;
  double max_age_s_;
  client::Connection
      slipd_;  // attached once a board was found; the last one's records hold what still stands
  bool told_away_ = false;
  std::string told_unknown_;
  std::int64_t alive_ms_ = 0;
  BoardFinder finder_;
};

}  // namespace slipd::modbus
