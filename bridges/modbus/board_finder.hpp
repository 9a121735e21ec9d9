// Finds slipd's board in shared memory, in a thread of its own: who asks slipd waits for it, and a slipd that
// hangs answers nobody. The loop gets a board that is mapped already, which is read without waiting.
// Functions are the loop's thread's.
#pragma once

#include <functional>
#include <memory>
#include <slipd.hpp>
#include <string>

#include "bridges/support/inventory.hpp"
#include "bridges/support/loop.hpp"

namespace slipd::modbus {

struct FoundBoard {
  // Attached, and from now on the loop's thread's.
  client::Connection slipd;
  // What slipd has as long as the board is open: a reload of slipd closes it.
  bridges::Inventory inventory;
};

struct BoardListener {
  std::function<void(FoundBoard&&)> found;
  // An attempt failed; there will be others. `why` is libslipd's text.
  std::function<void(const std::string& why)> away;
};

class BoardFinder {
 public:
  // Looks at once. Throws std::system_error.
  BoardFinder(bridges::Loop& loop, const std::string& socket, BoardListener listener);
  // Does not wait for slipd: a thread that does is left behind, with all that it uses, until slipd's time is
  // up.
  ~BoardFinder();
  BoardFinder(const BoardFinder&) = delete;
  BoardFinder& operator=(const BoardFinder&) = delete;

  // The last board is of no more use: looks until there is another. Without effect while it looks.
  void look();

 private:
  struct Shared;
  void hear();

  std::shared_ptr<Shared> shared_;
  BoardListener listener_;
  bridges::Loop::Watch watch_;
};

}  // namespace slipd::modbus
