// Tells slipd that the gripper lets go, so that a gel that relaxes is no slip (the method `releasing`). Waits
// for slipd, but not long. One thread at a time.
#pragma once

#include <set>
#include <slipd.hpp>
#include <string>
#include <vector>

namespace slipd::grip {

class ReleaseNotice {
 public:
  // fingers: names of slipd's sensors.
  ReleaseNotice(const std::string& socket, std::vector<std::string> fingers);

  // The gripper opens, which lasts some seconds at most.
  void opens() { tell(kOpeningS); }
  // It closes: what it holds from now on can slip.
  void closes() { tell(0); }

 private:
  static constexpr double kOpeningS = 2;

  void tell(double seconds);

  client::Connection slipd_;
  std::vector<std::string> fingers_;
  std::set<std::string> released_;  // told to and not yet told of the end
};

}  // namespace slipd::grip
