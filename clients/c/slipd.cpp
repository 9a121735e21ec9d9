// The functions of slipd.h. Each catches everything, so that no exception crosses the interface.
#include "clients/c/slipd.h"

#include <sys/epoll.h>
#include <sys/timerfd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <limits>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "clients/c/board_view.hpp"
#include "clients/c/connection.hpp"
#include "clients/c/estimate.hpp"

using nlohmann::json;
using slipd::UniqueFd;
using slipd::client::BoardView;
using slipd::client::clear;
using slipd::client::Clock;
using slipd::client::Connection;
using slipd::client::Failure;
using slipd::client::fill;
using slipd::client::monotonic_ns;

namespace {

constexpr double kLongestTimeout = 1e6;               // s: what counts as forever
constexpr double kFirstPause = 0.05, kLastPause = 2;  // s, between attempts to connect
// Longest sleep of slipd_wait before it looks at the heartbeat again, ns.
constexpr std::int64_t kLookNs = 50'000'000;
// A heartbeat that is older than so many of its periods is that of a slipd that has stopped. Fewer: a busy
// machine looks like a stop. The age of the estimate counts besides.
constexpr std::int64_t kBeatsMissed = 10;
constexpr std::array<std::pair<int, const char*>, 3> kEvents{
    {{SLIPD_EVENT_ESTIMATE, "estimate"}, {SLIPD_EVENT_ALERT, "alert"}, {SLIPD_EVENT_STATE, "state"}}};

double seconds_of(double timeout_s) noexcept {
  return std::isnan(timeout_s) ? 0 : std::clamp(timeout_s, 0.0, kLongestTimeout);
}

Clock::time_point after(double timeout_s) noexcept {
  return Clock::now() +
         std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds_of(timeout_s)));
}

}  // namespace

struct slipd_client {
  std::string path;
  std::array<char, 512> error{};
  Connection requests;

  // The subscription.
  Connection events;
  UniqueFd epoll, timer;
  std::string subscription;         // parameters as JSON; empty: there is none
  std::uint64_t subscribed_by = 0;  // id of the request
  double pause_s = kFirstPause;

  // The shared memory.
  Connection attached;
  BoardView board;
  std::vector<std::uint64_t> seen;  // of each slot: number of the record that slipd_wait returned last
};

namespace {

int note(slipd_client& s, int code, const char* text) noexcept {
  s.error.fill(0);
  std::strncpy(s.error.data(), text, s.error.size() - 1);
  return code;
}

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

// The same for a request: after a failure on the way the connection is given up, so that a late answer is not
// taken for another one's.
template <typename Body>
int requested(slipd_client* s, Body body) noexcept {
  const int code = guarded(s, body);
  if (s != nullptr && (code == SLIPD_TIMEOUT || code == SLIPD_DISCONNECTED || code == SLIPD_NO_MEMORY))
    s->requests.close();
  return code;
}

std::string call(slipd_client& s, std::string_view method, std::string_view params, int descriptor,
                 Clock::time_point until) {
  if (s.requests.connected()) {
    try {
      return s.requests.answer(s.requests.request(method, params, descriptor, until), until);
    } catch (const Failure& failure) {
      if (failure.code() != SLIPD_DISCONNECTED) throw;
      s.requests.close();  // slipd was restarted since the last request
    }
  }
  s.requests.connect(s.path);
  return s.requests.answer(s.requests.request(method, params, descriptor, until), until);
}

char* copy_of(const std::string& text) {
  char* const copy = static_cast<char*>(std::malloc(text.size() + 1));
  if (copy == nullptr) throw std::bad_alloc();
  std::memcpy(copy, text.c_str(), text.size() + 1);
  return copy;
}

std::string quoted(const char* name) {
  return json(name).dump(-1, ' ', true, json::error_handler_t::replace);
}

// --- subscription ---

void arm(const UniqueFd& timer, double pause_s) noexcept {
  itimerspec when{};
  when.it_value.tv_sec = static_cast<time_t>(pause_s);
  when.it_value.tv_nsec = static_cast<long>(1e9 * (pause_s - std::floor(pause_s))) + 1;
  timerfd_settime(timer.get(), 0, &when, nullptr);
}

void watch(const UniqueFd& epoll, int fd) {
  epoll_event event{};
  event.events = EPOLLIN;
  if (epoll_ctl(epoll.get(), EPOLL_CTL_ADD, fd, &event) != 0)
    throw Failure(SLIPD_NO_MEMORY, "the system has no room to watch a connection");
}

void start_subscription(slipd_client& s, Clock::time_point until) {
  s.events.connect(s.path);
  watch(s.epoll, s.events.fd());
  s.subscribed_by = s.events.request("subscribe", s.subscription, -1, until);
}

// A descriptor that is closed leaves the epoll by itself.
void lose_subscription(slipd_client& s) noexcept {
  s.events.close();
  arm(s.timer, s.pause_s);
  s.pause_s = std::min(2 * s.pause_s, kLastPause);
}

// One line; true if it is a notification, which fills `estimate`.
bool take_event(slipd_client& s, std::string_view line, double max_age_s, slipd_estimate& estimate) {
  const json message = json::parse(line, nullptr, false);
  if (!message.is_object()) return false;
  if (const auto error = message.find("error"); error != message.end()) {
    const bool ours = message.value("id", json()) == s.subscribed_by;
    throw Failure(ours ? SLIPD_REFUSED : SLIPD_DISCONNECTED, error->value("message", "slipd refuses this"));
  }
  const auto params = message.find("params");
  if (params == message.end()) {
    s.pause_s = kFirstPause;  // the answer: it is subscribed
    return false;
  }
  fill(estimate, *params, params->value("age_ms", json()), monotonic_ns(), max_age_s);
  const std::string event = message.value("method", "estimate");
  for (const auto& [bit, name] : kEvents) {
    if (event == name) estimate.event = bit;
  }
  return true;
}

int next_event(slipd_client& s, double max_age_s, Clock::time_point until, slipd_estimate& estimate) {
  if (s.subscription.empty())
    throw Failure(SLIPD_INVALID, "there is no subscription: call slipd_subscribe first");
  try {
    for (;;) {
      if (s.events.connected()) {
        std::string_view line;
        if (!s.events.line(line, until)) return SLIPD_TIMEOUT;
        if (take_event(s, line, max_age_s, estimate)) return SLIPD_DONE;
        continue;
      }
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
      epoll_event due{};
      if (epoll_wait(s.epoll.get(), &due, 1,
                     static_cast<int>(std::clamp<std::int64_t>(left, 0, 1'000'000'000))) <= 0)
        return SLIPD_TIMEOUT;
      arm(s.timer, kLongestTimeout);  // no longer readable
      start_subscription(s, Clock::now() + std::chrono::seconds(1));
    }
  } catch (...) {
    lose_subscription(s);
    clear(estimate, "", SLIPD_STATE_DISCONNECTED);
    throw;
  }
}

// --- shared memory ---

bool alive(const slipd_client& s, std::int64_t now_ns, double max_age_s) noexcept {
  const auto patience = static_cast<double>(kBeatsMissed * s.board.heartbeat_period_ns());
  const double allowed_ns = max_age_s > 0 ? std::max(patience, 1e9 * max_age_s) : patience;
  return !s.board.closed() && static_cast<double>(now_ns - s.board.heartbeat_ns()) <= allowed_ns;
}

// The slot; negative: a code to return, with `estimate` cleared.
int usable_slot(slipd_client& s, const char* name, std::int64_t now_ns, double max_age_s,
                slipd_estimate& estimate) noexcept {
  const auto refuse = [&](int code, const char* why) {
    clear(estimate, name == nullptr ? "" : name, SLIPD_STATE_DISCONNECTED);
    return note(s, code, why);
  };
  s.error.front() = 0;
  if (!s.board.mapped()) return refuse(SLIPD_ATTACH_ANEW, "not attached: call slipd_attach first");
  if (!alive(s, now_ns, max_age_s))
    return refuse(SLIPD_ATTACH_ANEW, "slipd has stopped or was reloaded: call slipd_attach again");
  const int slot = name == nullptr ? -1 : s.board.find(name);
  if (slot < 0) return refuse(SLIPD_INVALID, "there is no sensor or grasp of this name");
  return slot;
}

void attach(slipd_client& s, const char* wait_for, Clock::time_point until) {
  s.board.unmap();
  s.attached.close();
  s.attached.connect(s.path);
  const std::string params = R"({"wait":[)" + (wait_for == nullptr ? std::string() : quoted(wait_for)) + "]}";
  s.attached.answer(s.attached.request("attach", params, -1, until), until);
  const UniqueFd file = s.attached.take_descriptor();
  if (!file) throw Failure(SLIPD_DISCONNECTED, "slipd passed no memory");
  if (const std::string why = s.board.map(file); !why.empty()) throw Failure(SLIPD_INVALID, why);
  s.seen.assign(s.board.slots(), 0);
  while (s.board.heartbeat_ns() == 0) {  // until the first round of slipd that writes it
    if (Clock::now() >= until) throw Failure(SLIPD_TIMEOUT, "slipd writes nothing into its memory");
    const timespec moment{0, 100'000};
    nanosleep(&moment, nullptr);
  }
}

}  // namespace

const char* slipd_version(void) {
  return SLIPD_VERSION;
}

int slipd_open(slipd_client** out, const char* path) {
  if (out == nullptr) return SLIPD_INVALID;
  *out = nullptr;
  try {
    auto made = std::make_unique<slipd_client>();
    made->path = path == nullptr ? SLIPD_SOCKET : path;
    made->epoll = UniqueFd(epoll_create1(EPOLL_CLOEXEC));
    made->timer = UniqueFd(timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK));
    if (!made->epoll || !made->timer) return SLIPD_NO_MEMORY;
    watch(made->epoll, made->timer.get());
    *out = made.release();
    return SLIPD_DONE;
  } catch (const std::exception&) {
    return SLIPD_NO_MEMORY;
  }
}

int slipd_connect(slipd_client* s, double timeout_s) {
  return requested(s, [&] {
    call(*s, "version", "{}", -1, after(timeout_s));
    return SLIPD_DONE;
  });
}

void slipd_close(slipd_client* s) {
  delete s;
}

const char* slipd_error_text(const slipd_client* s) {
  return s == nullptr ? "" : s->error.data();
}

int slipd_gamma(slipd_client* s, const char* sensor, double max_age_s, double timeout_s,
                struct slipd_estimate* estimate) {
  if (estimate == nullptr || sensor == nullptr) return SLIPD_INVALID;
  clear(*estimate, sensor, SLIPD_STATE_DISCONNECTED);
  return requested(s, [&] {
    const json result =
        json::parse(call(*s, "gamma", R"({"sensor":)" + quoted(sensor) + "}", -1, after(timeout_s)));
    const json& values = result.at("sensors").at(0);
    fill(*estimate, values, values.value("age_ms", json()), monotonic_ns(), max_age_s);
    return SLIPD_DONE;
  });
}

int slipd_grasp(slipd_client* s, const char* grasp, double max_age_s, double timeout_s,
                struct slipd_estimate* estimate) {
  if (estimate == nullptr || grasp == nullptr) return SLIPD_INVALID;
  clear(*estimate, grasp, SLIPD_STATE_DISCONNECTED);
  return requested(s, [&] {
    const json result = json::parse(call(*s, "gamma", "{}", -1, after(timeout_s)));
    for (const json& values : result.at("grasps")) {
      if (values.at("grasp") != grasp) continue;
      json oldest_ms = 0;
      for (const json& member : values.at("sensors")) {
        for (const json& sensor : result.at("sensors")) {
          if (sensor.at("sensor") != member || oldest_ms.is_null()) continue;
          const json& age_ms = sensor.at("age_ms");
          if (age_ms.is_null() || age_ms > oldest_ms) oldest_ms = age_ms;
        }
      }
      fill(*estimate, values, oldest_ms, monotonic_ns(), max_age_s);
      return static_cast<int>(SLIPD_DONE);
    }
    throw Failure(SLIPD_REFUSED, std::string("there is no grasp ") + grasp);
  });
}

int slipd_call(slipd_client* s, const char* method, const char* params, int descriptor, double timeout_s,
               char** result) {
  if (result == nullptr || method == nullptr) return SLIPD_INVALID;
  *result = nullptr;
  return requested(s, [&] {
    const json named = json::parse(params == nullptr ? "{}" : params, nullptr, false);
    if (!named.is_object()) throw Failure(SLIPD_INVALID, "params are no JSON object");
    const json name(method);
    const std::string text = name.dump(-1, ' ', true, json::error_handler_t::replace);
    *result = copy_of(call(*s, text.substr(1, text.size() - 2), named.dump(), descriptor, after(timeout_s)));
    return SLIPD_DONE;
  });
}

int slipd_sensors(slipd_client* s, double timeout_s, char** result) {
  return slipd_call(s, "sensors", nullptr, -1, timeout_s, result);
}

int slipd_status(slipd_client* s, double timeout_s, char** result) {
  return slipd_call(s, "status", nullptr, -1, timeout_s, result);
}

int slipd_frame(slipd_client* s, const char* sensor, double timeout_s, char** result) {
  if (sensor == nullptr || result == nullptr) return SLIPD_INVALID;
  *result = nullptr;
  return requested(s, [&] {
    *result = copy_of(call(*s, "frame", R"({"sensor":)" + quoted(sensor) + "}", -1, after(timeout_s)));
    return SLIPD_DONE;
  });
}

void slipd_free(char* text) {
  std::free(text);
}

int slipd_subscribe(slipd_client* s, const char* sensor, double max_rate_hz, int events, double timeout_s) {
  return guarded(s, [&] {
    const auto until = after(timeout_s);
    json params = json::object();
    if (sensor != nullptr) params["sensors"] = {sensor};
    if (max_rate_hz > 0) params["max_rate_hz"] = max_rate_hz;
    for (const auto& [bit, name] : kEvents) {
      if ((events & bit) != 0) params["events"].push_back(name);
    }
    s->events.close();
    s->subscription = params.dump(-1, ' ', true, json::error_handler_t::replace);
    s->pause_s = kFirstPause;
    try {
      start_subscription(*s, until);
      s->events.answer(s->subscribed_by, until);
    } catch (...) {
      s->events.close();
      s->subscription.clear();
      throw;
    }
    return SLIPD_DONE;
  });
}

int slipd_fd(const slipd_client* s) {
  return s == nullptr ? -1 : s->epoll.get();
}

int slipd_next(slipd_client* s, double max_age_s, double timeout_s, struct slipd_estimate* estimate) {
  if (estimate == nullptr) return SLIPD_INVALID;
  clear(*estimate, "", SLIPD_STATE_STALE);
  return guarded(s, [&] { return next_event(*s, max_age_s, after(timeout_s), *estimate); });
}

int slipd_attach(slipd_client* s, const char* wait_for, double timeout_s) {
  const int code = guarded(s, [&] {
    attach(*s, wait_for, after(timeout_s));
    return SLIPD_DONE;
  });
  if (s != nullptr && code != SLIPD_DONE) s->board.unmap();
  return code;
}

int slipd_latest(slipd_client* s, const char* name, double max_age_s, struct slipd_estimate* estimate) {
  if (s == nullptr || estimate == nullptr) return SLIPD_INVALID;
  const std::int64_t now_ns = monotonic_ns();
  const int slot = usable_slot(*s, name, now_ns, max_age_s, *estimate);
  if (slot < 0) return slot;
  fill(*estimate, s->board.name(slot), s->board.record(slot), now_ns, max_age_s);
  return SLIPD_DONE;
}

int slipd_wait(slipd_client* s, const char* name, double max_age_s, double timeout_s,
               struct slipd_estimate* estimate) {
  if (s == nullptr || estimate == nullptr) return SLIPD_INVALID;
  const std::int64_t until_ns = monotonic_ns() + static_cast<std::int64_t>(1e9 * seconds_of(timeout_s));
  for (;;) {
    const std::int64_t now_ns = monotonic_ns();
    const int slot = usable_slot(*s, name, now_ns, max_age_s, *estimate);
    if (slot < 0) return slot;
    const std::uint32_t published = s->board.published(slot);
    const auto record = s->board.record(slot);
    fill(*estimate, s->board.name(slot), record, now_ns, max_age_s);
    std::uint64_t& seen = s->seen[static_cast<std::size_t>(slot)];
    if (record.number > seen) {
      estimate->dropped = seen == 0 ? 0 : record.number - seen - 1;
      seen = record.number;
      return SLIPD_DONE;
    }
    if (now_ns >= until_ns) return SLIPD_TIMEOUT;
    s->board.wait(slot, published, std::min(until_ns, now_ns + kLookNs));
  }
}

double slipd_heartbeat_age(const slipd_client* s) {
  if (s == nullptr || !s->board.mapped() || s->board.closed()) return std::numeric_limits<double>::infinity();
  return 1e-9 * static_cast<double>(monotonic_ns() - s->board.heartbeat_ns());
}
