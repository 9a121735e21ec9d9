// `slipctl watch`: follows the daemon's estimates until it is stopped; a live view on a terminal, lines
// elsewhere.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace slipctl {

struct WatchOptions {
  std::string socket;                                // path of the daemon's socket
  std::vector<std::string> names;                    // of sensors and grasps; empty: all
  std::string grip = "/run/slipd-grip/orders.sock";  // slipd-grip's socket for orders
  std::optional<double> seconds;                     // end after this, s; absent: at q or a signal
  double lines_per_s = 5;                            // per sensor, where stdout is not a terminal
  bool json = false;                                 // print each estimate, one object a line
  bool plain = false;                                // print lines even on a terminal
  bool summary = false;                              // print statistics at the end
  bool expect_slip = false;                          // exit with 1 if no slip was seen
  std::string picture;                               // file for the last screen as SVG; empty: none
};

// The exit code. Throws ClientError.
int watch(const WatchOptions& options);

}  // namespace slipctl
