// What a client sends again and again, read without making a tree of values first: one request whose members
// are plain. io thread.
#pragma once

#include <optional>
#include <string_view>

#include "daemon/rpc/rpc.hpp"

namespace slipd::rpc {

// The same as parse() would find in it; none for all that is not as plain: then parse() has to see for
// itself. Plain are strings of printable ASCII without escapes, an id that is one or a whole number from 0 to
// 1e18, params whose values are all such strings, and no member twice.
std::optional<Request> plain_request(std::string_view text);

}  // namespace slipd::rpc
