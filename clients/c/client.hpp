// slipd_client, which the functions of slipd.h share, and the return of their errors as codes: no exception
// crosses the interface. A client belongs to one thread at a time.
#pragma once

#include <array>
#include <cstdint>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "clients/c/board_view.hpp"
#include "clients/c/connection.hpp"
#include "clients/c/slipd.h"
#include "core/storage/unique_fd.hpp"

namespace slipd::client {

// Between attempts to connect: the first pause, and the longest, s.
inline constexpr double kFirstPause = 0.05, kLastPause = 2;
// Time-out that counts as forever, s.
inline constexpr double kLongestTimeout = 1e6;

// A time-out as a caller gave it, 0 … kLongestTimeout; NaN is 0.
double seconds_of(double timeout_s) noexcept;
// The end of a time-out that begins now.
Clock::time_point after(double timeout_s) noexcept;
// A name as JSON text, whatever bytes it has.
std::string quoted(const char* name);

}  // namespace slipd::client

struct slipd_client {
  std::string path;
  // Of slipd_error_text().
  std::array<char, 512> error{};
  // slipd_gamma and all that has an answer.
  slipd::client::Connection requests;

  // The subscription.
  slipd::client::Connection events;
  slipd::UniqueFd epoll, timer;
  std::string subscription;         // parameters as JSON; empty: there is none
  std::uint64_t subscribed_by = 0;  // id of the request
  // Of a subscription of one sensor: what is known of it while no estimate comes; else without a name.
  slipd_estimate silent{};
  double pause_s = slipd::client::kFirstPause;  // before the next attempt to connect
  std::string last_event;                       // the message of slipd_event_text(); empty: there is none
  mutable std::string last_event_text;          // made from it when it is asked for

  // The shared memory.
  slipd::client::Connection attached;
  slipd::client::BoardView board;   // of the last slipd_attach that was done
  bool board_serves = false;        // false: a slipd_attach has failed since; only its alerts are used
  std::vector<std::uint64_t> seen;  // of each slot: number of the record that slipd_wait returned last
};

namespace slipd::client {

// Keeps the text for slipd_error_text(); returns `code`.
int note(slipd_client& s, int code, const char* text) noexcept;

// Adds a connection to the descriptors of slipd_fd().
void watch(const UniqueFd& epoll, int fd);

// The result of a request, on a new connection if slipd has closed the present one. Throws Failure.
Json call(slipd_client& s, std::string_view method, std::string_view params, Clock::time_point until);

// Calls `body`, which returns a code, and turns exceptions into codes.
template <typename Body>
int guarded(slipd_client* s, Body body) noexcept {
  if (s == nullptr) return SLIPD_INVALID;
  try {
    s->error.front() = 0;
    return body();
  } catch (const Failure& failure) {
    return note(*s, failure.code(), failure.what());
  } catch (const std::bad_alloc&) {
    return note(*s, SLIPD_NO_MEMORY, "there is no memory left");
  } catch (const std::exception& error) {
    return note(*s, SLIPD_DISCONNECTED, error.what());
  }
}

}  // namespace slipd::client
