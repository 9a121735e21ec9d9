#include "clients/c/recording.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>
#include <vector>

#include "clients/c/slipd.h"

namespace slipd::client {
namespace {

constexpr double kLongestRecordingS = 86400;
constexpr std::size_t kCopiedAtOnce = std::size_t{256} * 1024;

void write_all(int file, const char* bytes, std::size_t count) {
  while (count > 0) {
    const auto taken = write(file, bytes, count);
    if (taken > 0) {
      bytes += taken;
      count -= static_cast<std::size_t>(taken);
    } else if (taken < 0 && errno != EINTR) {
      throw Failure(SLIPD_INVALID,
                    "the recording cannot be written: " + std::generic_category().message(errno) +
                        "; what was written before can be read");
    }
  }
}

// Until slipd has closed its end.
void copy(const UniqueFd& from, int file, Clock::time_point until) {
  std::vector<char> piece(kCopiedAtOnce);
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    pollfd ready{from.get(), POLLIN, 0};
    const int some = poll(&ready, 1, static_cast<int>(std::clamp<std::int64_t>(left, 0, 1'000'000'000)));
    if (some == 0) throw Failure(SLIPD_TIMEOUT, "slipd does not end the recording in time");
    const auto got = some < 0 ? -1 : recv(from.get(), piece.data(), piece.size(), MSG_DONTWAIT);
    if (got == 0) return;
    if (got > 0) {
      write_all(file, piece.data(), static_cast<std::size_t>(got));
    } else if (errno != EINTR && errno != EAGAIN) {
      throw Failure(SLIPD_DISCONNECTED, "reading the recording: " + std::generic_category().message(errno));
    }
  }
}

}  // namespace

Json record(Connection& connection, std::string_view sensor, double seconds, int file,
            Clock::duration patience, const std::function<void(Json&&)>& other) {
  if (!(seconds > 0 && seconds <= kLongestRecordingS))
    throw Failure(SLIPD_INVALID, "a recording takes more than 0 and at most 86400 seconds");
  const auto until = Clock::now() + patience +
                     std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  const std::string params =
      R"({"sensor":)" + std::string(sensor) + R"(,"seconds":)" + Json(seconds).dump() + "}";
  const Json answer = connection.answer(connection.request("record", params, until),
                                        std::min(until, Clock::now() + patience), other);
  UniqueFd from = connection.take_descriptor();
  const auto number = answer.find("recording");
  if (!from || number == answer.end())
    throw Failure(SLIPD_DISCONNECTED, "slipd passed no descriptor to read the recording from: it is too old");
  copy(from, file, until);
  for (Json message; connection.message(message, until);) {
    const auto params_of = message.find("params");
    const auto method = message.find("method");
    const bool ours = method != message.end() && *method == "recorded" && params_of != message.end() &&
                      params_of->is_object() && params_of->contains("recording") &&
                      params_of->at("recording") == *number;
    if (ours) return std::move(*params_of);
    if (other) other(std::move(message));
  }
  throw Failure(SLIPD_TIMEOUT, "slipd does not say how the recording ended");
}

}  // namespace slipd::client
