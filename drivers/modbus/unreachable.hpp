// Why a Modbus TCP device cannot be reached, for people. Set-up thread; may wait for name resolution.
#pragma once

#include <string>

namespace slipd::modbus {

// One line: what is wrong, and what to do. `error`: errno of the connection that failed.
std::string why_unreachable(const std::string& host, int port, int error);

}  // namespace slipd::modbus
