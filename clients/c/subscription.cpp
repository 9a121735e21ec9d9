// The functions of slipd.h for estimates as they come on the socket, and for connecting again.
#include <sys/epoll.h>
#include <sys/timerfd.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <string_view>
#include <utility>

#include "clients/c/client.hpp"
#include "clients/c/estimate.hpp"
#include "clients/c/estimate_reader.hpp"
#include "clients/c/json_values.hpp"

using namespace slipd::client;
using slipd::UniqueFd;

namespace {

constexpr std::array<std::pair<int, const char*>, 3> kEvents{
    {{SLIPD_EVENT_ESTIMATE, "estimate"}, {SLIPD_EVENT_ALERT, "alert"}, {SLIPD_EVENT_STATE, "state"}}};

void arm(const UniqueFd& timer, double pause_s) noexcept {
  itimerspec when{};
  when.it_value.tv_sec = static_cast<time_t>(pause_s);
  when.it_value.tv_nsec = static_cast<long>(1e9 * (pause_s - std::floor(pause_s))) + 1;
  timerfd_settime(timer.get(), 0, &when, nullptr);
}

void start_subscription(slipd_client& s, Clock::time_point until) {
  s.events.connect(s.path);
  watch(s.epoll, s.events.fd());
  s.subscribed_by = s.events.request("subscribe", s.subscription, until);
}

// A descriptor that is closed leaves the epoll by itself.
void lose_subscription(slipd_client& s) noexcept {
  s.events.close();
  arm(s.timer, s.pause_s);
  s.pause_s = std::min(2 * s.pause_s, kLastPause);
}

// There is no estimate. What is known: which sensor it would be of, and an alert that stands.
void fill_silence(const slipd_client& s, int state, slipd_estimate& estimate) noexcept {
  clear(estimate, s.silent.name, state);
  take_last_alert(s.silent.alert, s.silent.alert_cause, estimate);
}

void fill_event(slipd_client& s, std::string_view line, const EstimateValues& values, std::string_view method,
                double max_age_s, slipd_estimate& estimate) {
  fill(estimate, values, monotonic_ns(), max_age_s);
  for (const auto& [bit, name] : kEvents) {
    if (method == name) estimate.event = bit;
  }
  if (s.silent.name[0] != 0) take_last_alert(estimate.alert, estimate.alert_cause, s.silent);
  s.last_event = line;
}

// True: the message is a notification, which fills `estimate`.
bool take_event(slipd_client& s, std::string_view line, double max_age_s, slipd_estimate& estimate) {
  NotificationReader reader;
  if (Json::sax_parse(line, &reader) && reader.complete()) {
    fill_event(s, line, reader.values(), reader.method(), max_age_s, estimate);
    return true;
  }
  const Json message = message_of(line);
  throw_error_of(message, member(message, "id") == s.subscribed_by);
  const auto params = message.find("params");
  if (params == message.end()) {
    s.pause_s = kFirstPause;  // the answer: it is subscribed
    return false;
  }
  fill_event(s, line, estimate_from(*params), text(message, "method", "estimate"), max_age_s, estimate);
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
    fill_silence(s, SLIPD_STATE_DISCONNECTED, estimate);
    throw;
  }
}

}  // namespace

int slipd_subscribe(slipd_client* s, const char* sensor, double max_rate_hz, int events, double timeout_s) {
  return guarded(s, [&] {
    const auto until = after(timeout_s);
    Json params = Json::object();
    if (sensor != nullptr) params["sensors"] = {sensor};
    if (max_rate_hz > 0) params["max_rate_hz"] = max_rate_hz;
    for (const auto& [bit, name] : kEvents) {
      if ((events & bit) != 0) params["events"].push_back(name);
    }
    s->events.close();
    clear(s->silent, sensor == nullptr ? "" : sensor, SLIPD_STATE_STALE);
    s->subscription = params.dump(-1, ' ', true, Json::error_handler_t::replace);
    s->pause_s = kFirstPause;
    arm(s->timer, kLongestTimeout);  // not readable for an earlier subscription
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
  if (s == nullptr) return SLIPD_INVALID;
  fill_silence(*s, SLIPD_STATE_STALE, *estimate);
  s->last_event.clear();
  return guarded(s, [&] { return next_event(*s, max_age_s, after(timeout_s), *estimate); });
}

const char* slipd_event_text(const slipd_client* s) {
  if (s == nullptr || s->last_event.empty()) return "";
  try {
    s->last_event_text =
        message_of(s->last_event).at("params").dump(-1, ' ', false, Json::error_handler_t::replace);
    return s->last_event_text.c_str();
  } catch (const std::exception&) {
    return "";
  }
}
