// Starts the program anew when this computer's addresses change: Cyclone DDS uses those that it finds at its
// start, and nodes that start later give the new ones. The loop's thread.
#pragma once

#include <vector>

#include "bridges/ros2/dds/host_network.hpp"
#include "bridges/ros2/dds/node.hpp"
#include "bridges/support/loop.hpp"

namespace slipd::ros2 {

class HostWatch {
 public:
  // For a node of `options`; only one whose interfaces are kHost follows the addresses. Throws
  // std::system_error.
  HostWatch(bridges::Loop& loop, const NodeOptions& options);

 private:
  void note();

  bool follows_;
  AddressChanges changes_;
  std::vector<HostInterface> host_;  // after changes_, so that no change is missed
  bridges::Loop::Watch watch_;
};

}  // namespace slipd::ros2
