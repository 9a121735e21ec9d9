// `slipctl watch`: follows the daemon until told to stop; a live view on a terminal, lines elsewhere.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace slipctl {

struct WatchOptions {
  std::string socket;
  std::vector<std::string> sensors;  // empty: all
  std::optional<double> seconds;     // absent: until q or a signal
  double lines_per_s = 5;            // where stdout is no terminal
  bool json = false;                 // estimates as they come, one object a line
  bool plain = false;                // lines even on a terminal
  bool summary = false;              // at the end: what happened
  bool expect_slip = false;          // fail when no slip was seen
  std::string picture;               // file that gets the last screen as SVG; empty: none
};

// The exit code. Throws ClientError.
int watch(const WatchOptions& options);

}  // namespace slipctl
