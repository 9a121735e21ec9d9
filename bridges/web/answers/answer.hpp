// slipd's answer to a request, with the times that its ages need. Any thread.
#pragma once

#include <string>

namespace slipd::web {

struct Answer {
  // JSON.
  std::string text;
  // When slipd was asked, and when the answer was read, ms of a steady clock. Its ages may be those of any
  // time between, since this program may have been stopped meanwhile.
  double asked_ms = 0, had_ms = 0;

  double waited_ms() const noexcept { return had_ms - asked_ms; }
};

}  // namespace slipd::web
