// Datagrams to Unix sockets, as systemd and journald read them.
#pragma once

#include <string_view>

namespace slipd {

// `address`: a path, or of an abstract socket with @ in front, 2 to 107 bytes; another is sent nothing. Waits
// while the receiver has no room. An error is ignored: there is nowhere to tell it. All are sent from one
// descriptor, which is there also when slipd has none left. Any thread.
void send_datagram(std::string_view address, std::string_view bytes) noexcept;

}  // namespace slipd
