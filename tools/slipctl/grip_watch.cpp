#include "tools/slipctl/grip_watch.hpp"

#include <sys/socket.h>

#include <chrono>
#include <string_view>

#include "clients/c/connection.hpp"
#include "clients/c/json_values.hpp"

namespace slipctl {
namespace {

using slipd::client::number;
using slipd::client::text;

constexpr std::chrono::milliseconds kPatience{100};
constexpr std::string_view kOrder = "status\n";

GripWatch unknown(const char* why) {
  GripWatch grip;
  grip.state = why;
  return grip;
}

GripWatch grip_from(std::string_view line) {
  const slipd::client::Json status = slipd::client::Json::parse(line, nullptr, false);
  if (!status.is_object()) return unknown("says what is no status");
  const std::string gripper = text(status, "gripper");
  return {.state = text(status, "state"),
          .why = text(status, "why"),
          .force_n = number(status, "force_n"),
          .width_mm = number(status, "width_mm"),
          .trouble = gripper == "answers" ? text(status, "trouble") : gripper};
}

}  // namespace

std::optional<GripWatch> ask_grip(const std::string& path) {
  slipd::client::Connection grip;
  try {
    grip.connect(path);
  } catch (const slipd::client::Failure&) {
    return std::nullopt;
  }
  const GripWatch silent = unknown("does not answer");
  try {
    if (::send(grip.fd(), kOrder.data(), kOrder.size(), MSG_NOSIGNAL) < 0) return silent;
    std::string_view line;
    return grip.line(line, std::chrono::steady_clock::now() + kPatience) ? grip_from(line) : silent;
  } catch (const slipd::client::Failure&) {
    return silent;
  }
}

}  // namespace slipctl
