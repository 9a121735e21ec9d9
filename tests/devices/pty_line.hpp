// A pseudo-terminal in place of a serial line: the device's end, and a symbolic link to the host's.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "tests/devices/port.hpp"

namespace slipd::devices {

class PtyLine {
 public:
  explicit PtyLine(std::string link) : link_(std::move(link)) {}
  ~PtyLine();
  PtyLine(const PtyLine&) = delete;
  PtyLine& operator=(const PtyLine&) = delete;

  // Throws std::system_error. The host's end stays open here as well, so that a host may come and go.
  void plug();
  void unplug();

  void watch(std::vector<pollfd>& waits) const;
  // Whether the host has sent something.
  bool heard() const;
  int device() const { return device_.get(); }  // -1: unplugged
  const std::string& link() const { return link_; }

 private:
  std::string link_;
  Fd device_, host_;
};

}  // namespace slipd::devices
