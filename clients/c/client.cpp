// What begins and ends a slipd_client.
#include "clients/c/client.hpp"

#include <sys/epoll.h>
#include <sys/timerfd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

namespace slipd::client {

double seconds_of(double timeout_s) noexcept {
  return std::isnan(timeout_s) ? 0 : std::clamp(timeout_s, 0.0, kLongestTimeout);
}

Clock::time_point after(double timeout_s) noexcept {
  return Clock::now() +
         std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds_of(timeout_s)));
}

std::string quoted(const char* name) {
  return Json(name).dump(-1, ' ', true, Json::error_handler_t::replace);
}

int note(slipd_client& s, int code, const char* text) noexcept {
  s.error.fill(0);
  std::strncpy(s.error.data(), text, s.error.size() - 1);
  return code;
}

void watch(const UniqueFd& epoll, int fd) {
  epoll_event event{};
  event.events = EPOLLIN;
  if (epoll_ctl(epoll.get(), EPOLL_CTL_ADD, fd, &event) != 0)
    throw Failure(SLIPD_NO_MEMORY, "the system has no room to watch a connection");
}

Json call(slipd_client& s, std::string_view method, std::string_view params, Clock::time_point until) {
  if (s.requests.connected()) {
    try {
      return s.requests.answer(s.requests.request(method, params, until), until);
    } catch (const Failure& failure) {
      if (failure.code() != SLIPD_DISCONNECTED) throw;
      s.requests.close();  // slipd was restarted since the last request
    }
  }
  s.requests.connect(s.path);
  return s.requests.answer(s.requests.request(method, params, until), until);
}

}  // namespace slipd::client

using namespace slipd::client;

const char* slipd_version(void) {
  return SLIPD_VERSION;
}

int slipd_open(slipd_client** out, const char* path) {
  if (out == nullptr) return SLIPD_INVALID;
  *out = nullptr;
  try {
    auto made = std::make_unique<slipd_client>();
    made->path = path == nullptr ? SLIPD_SOCKET : path;
    made->epoll = slipd::UniqueFd(epoll_create1(EPOLL_CLOEXEC));
    made->timer = slipd::UniqueFd(timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK));
    if (!made->epoll || !made->timer) return SLIPD_NO_MEMORY;
    watch(made->epoll, made->timer.get());
    *out = made.release();
    return SLIPD_DONE;
  } catch (const std::exception&) {
    return SLIPD_NO_MEMORY;
  }
}

void slipd_close(slipd_client* s) {
  delete s;
}

const char* slipd_error_text(const slipd_client* s) {
  return s == nullptr ? "" : s->error.data();
}
