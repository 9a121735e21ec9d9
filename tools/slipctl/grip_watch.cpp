#include "tools/slipctl/grip_watch.hpp"

#include <sys/socket.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <string_view>

#include "clients/c/connection.hpp"

namespace slipctl {
namespace {

using Status = nlohmann::json;

constexpr std::chrono::milliseconds kPatience{100};
constexpr std::string_view kOrder = "status\n";

std::optional<double> number_in(const Status& status, const char* key) {
  const auto found = status.find(key);
  return found != status.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
}

std::string text_in(const Status& status, const char* key) {
  const auto found = status.find(key);
  return found != status.end() && found->is_string() ? found->get<std::string>() : std::string();
}

GripWatch unknown(const char* why) {
  GripWatch grip;
  grip.state = why;
  return grip;
}

GripWatch grip_from(std::string_view line) {
  const Status status = Status::parse(line, nullptr, false);
  if (!status.is_object()) return unknown("says what is no status");
  const std::string gripper = text_in(status, "gripper");
  return {.state = text_in(status, "state"),
          .why = text_in(status, "why"),
          .force_n = number_in(status, "force_n"),
          .width_mm = number_in(status, "width_mm"),
          .trouble = gripper == "answers" ? "" : gripper};
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
