#include "tests/devices/pty_line.hpp"

#include <fcntl.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

namespace slipd::devices {

PtyLine::~PtyLine() {
  ::unlink(link_.c_str());
}

void PtyLine::plug() {
  int device = -1, host = -1;
  char name[64];
  termios raw{};
  ::cfmakeraw(&raw);
  checked(::openpty(&device, &host, name, &raw, nullptr), "pseudo-terminal");
  device_ = Fd(device);
  host_ = Fd(host);
  ::unlink(link_.c_str());
  checked(::symlink(name, link_.c_str()), "symbolic link " + link_);
}

void PtyLine::unplug() {
  ::unlink(link_.c_str());
  device_ = Fd();
  host_ = Fd();
}

void PtyLine::watch(std::vector<pollfd>& waits) const {
  if (device_) waits.push_back({device_.get(), POLLIN, 0});
}

bool PtyLine::heard() const {
  pollfd wait{device_.get(), POLLIN, 0};
  return device_ && ::poll(&wait, 1, 0) == 1;
}

}  // namespace slipd::devices
