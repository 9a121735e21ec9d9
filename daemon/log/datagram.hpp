// Datagrams to Unix sockets, as systemd and journald read them.
#pragma once

#include <string_view>

namespace slipd {

// While the receiver has no room: wait, but no longer than 0.1 s, or lose it. A receiver that hangs must not
// make slipd hang.
enum class WhenFull { wait, lose };

// `address`: a path, or of an abstract socket with @ in front, 2 to 107 bytes; another is sent nothing.
// False: it was not sent. All are sent from one descriptor, which is there also when slipd has none left. Any
// thread.
bool send_datagram(std::string_view address, std::string_view bytes, WhenFull when_full) noexcept;

}  // namespace slipd
