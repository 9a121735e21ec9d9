// Tells people and systemd what has become of the messages of all lanes, every two seconds and at the end.
// The loop's thread.
#pragma once

#include <memory>
#include <vector>

#include "bridges/feed_lane/lane.hpp"
#include "bridges/support/loop.hpp"

namespace slipd::feed {

class Teller {
 public:
  // `lanes` must live longer; they may come later, before the loop runs.
  Teller(bridges::Loop& loop, const std::vector<std::unique_ptr<Lane>>& lanes);
  // Logs all counts.
  ~Teller();
  Teller(const Teller&) = delete;
  Teller& operator=(const Teller&) = delete;

 private:
  void tell();

  const std::vector<std::unique_ptr<Lane>>& lanes_;
  std::vector<Account> told_;  // of each lane, at the last report
  bridges::Loop::Timer report_;
};

}  // namespace slipd::feed
