// A fast parser of simple requests, which builds no tree of values. Called from one thread: io.
#pragma once

#include <optional>
#include <string_view>

#include "daemon/rpc/protocol/rpc.hpp"

namespace slipd::rpc {

// The request, as parse() would return it; none if the line is not simple, so that parse() has to read it. In
// a simple request strings are printable ASCII without escapes, the id is such a string or an integer from 0
// to 1e18, all values of params are such strings, and no member is given twice.
std::optional<Request> plain_request(std::string_view text);

}  // namespace slipd::rpc
