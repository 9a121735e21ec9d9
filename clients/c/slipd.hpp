// libslipd for C++20: slipd.h with ownership, exceptions and std::optional. Header only; link with libslipd.
//
//   slipd::client::Connection slipd;
//   slipd.subscribe("left");
//   for (;;) {
//     const slipd::client::Estimate now = slipd.next(0.05, 1.0);  // none older than 50 ms
//     if (const auto margin = now.margin()) command(*margin); else hold_firmly(now.state_name());
//   }
//
// A Connection belongs to one thread at a time. Estimates are values.
#pragma once

#include <slipd.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace slipd::client {

// What slipd refuses, or what is missing to ask it: code() is SLIPD_REFUSED, SLIPD_INVALID,
// SLIPD_DISCONNECTED, …
class Error : public std::runtime_error {
 public:
  Error(int code, const std::string& text) : std::runtime_error(text), code_(code) {}
  int code() const noexcept { return code_; }

 private:
  int code_;
};

// An estimate that expires: its margin is gone once it is older than was allowed.
class Estimate {
 public:
  // All fields as they were handed out.
  const slipd_estimate& fields() const noexcept { return fields_; }
  // The safety margin now; none unless state is ok and it is young enough.
  std::optional<double> margin() const noexcept {
    const double now = slipd_margin(&fields_);
    return std::isnan(now) ? std::nullopt : std::optional(now);
  }
  // "ok", "stale", "disconnected", … when it was handed out.
  std::string_view state_name() const noexcept { return slipd_state_name(fields_.state); }
  // Whether it was not returned before.
  bool is_new() const noexcept { return is_new_; }

 private:
  friend class Connection;
  slipd_estimate fields_{};
  bool is_new_ = false;
};

class Connection {
 public:
  explicit Connection(const std::string& path = SLIPD_SOCKET) {
    slipd_client* made = nullptr;
    if (slipd_open(&made, path.c_str()) != SLIPD_DONE) throw std::bad_alloc();
    client_.reset(made);
  }

  // Requests. Throw Error, also SLIPD_TIMEOUT. Seconds as in slipd.h.
  Estimate gamma(const std::string& sensor, double max_age_s, double timeout_s = 1) {
    Estimate estimate;
    check(slipd_gamma(get(), sensor.c_str(), max_age_s, timeout_s, &estimate.fields_));
    return estimate;
  }
  Estimate grasp(const std::string& name, double max_age_s, double timeout_s = 1) {
    Estimate estimate;
    check(slipd_grasp(get(), name.c_str(), max_age_s, timeout_s, &estimate.fields_));
    return estimate;
  }
  // Any method, as JSON text. `descriptor`: -1; slipd takes none.
  std::string call(const std::string& method, const std::string& params = "{}", int descriptor = -1,
                   double timeout_s = 1) {
    char* text = nullptr;
    check(slipd_call(get(), method.c_str(), params.c_str(), descriptor, timeout_s, &text));
    const std::unique_ptr<char, void (*)(char*)> owned(text, slipd_free);
    return text;
  }

  // Records a sensor into `fd`; the account of it, as JSON text. Throws Error if it is not whole.
  std::string record(const std::string& sensor, double seconds, int fd, double timeout_s = 10) {
    char* text = nullptr;
    const int code = slipd_record(get(), sensor.c_str(), seconds, fd, timeout_s, &text);
    const std::unique_ptr<char, void (*)(char*)> owned(text, slipd_free);
    check(code);
    return text;
  }

  // Estimates by the socket; empty: of all sensors. Throws Error.
  void subscribe(const std::string& sensor = {}, double max_rate_hz = 0, int events = SLIPD_EVENT_ESTIMATE,
                 double timeout_s = 1) {
    check(slipd_subscribe(get(), sensor.empty() ? nullptr : sensor.c_str(), max_rate_hz, events, timeout_s));
  }
  // The next estimate. Not new: none came in time, or slipd is away (state "disconnected"; it connects again
  // by itself). Throws Error if slipd refuses the subscription.
  Estimate next(double max_age_s, double timeout_s) {
    Estimate estimate;
    estimate.is_new_ = lenient(slipd_next(get(), max_age_s, timeout_s, &estimate.fields_));
    return estimate;
  }
  // To poll for next().
  int fd() const noexcept { return slipd_fd(get()); }

  // Maps the shared memory; empty: without wait(). Throws Error.
  void attach(const std::string& wait_for = {}, double timeout_s = 1) {
    check(slipd_attach(get(), wait_for.empty() ? nullptr : wait_for.c_str(), timeout_s));
  }
  // From the shared memory. State "disconnected": call attach again. Throw Error for an unknown name.
  Estimate latest(const char* name, double max_age_s) {
    Estimate estimate;
    estimate.is_new_ = lenient(slipd_latest(get(), name, max_age_s, &estimate.fields_));
    return estimate;
  }
  Estimate wait(const char* name, double max_age_s, double timeout_s) {
    Estimate estimate;
    estimate.is_new_ = lenient(slipd_wait(get(), name, max_age_s, timeout_s, &estimate.fields_));
    return estimate;
  }

  // For what this class lacks.
  slipd_client* get() const noexcept { return client_.get(); }

 private:
  void check(int code) const {
    if (code != SLIPD_DONE) throw Error(code, slipd_error_text(get()));
  }
  bool lenient(int code) const {
    if (code == SLIPD_REFUSED || code == SLIPD_INVALID || code == SLIPD_NO_MEMORY) check(code);
    return code == SLIPD_DONE;
  }
  struct Close {
    void operator()(slipd_client* client) const noexcept { slipd_close(client); }
  };
  std::unique_ptr<slipd_client, Close> client_;
};

// Frames of a sensor from this program, for a sensor whose driver is "push".
class Source {
 public:
  // Connects to nothing yet. Throws Error for frames that no sensor has.
  Source(const std::string& sensor, const slipd_frames& frames, const std::string& path = SLIPD_SOCKET) {
    slipd_source* made = nullptr;
    const int code = slipd_source_open(&made, sensor.c_str(), path.c_str(), &frames);
    if (code == SLIPD_NO_MEMORY) throw std::bad_alloc();
    if (code != SLIPD_DONE) throw Error(code, "these are no frames that a sensor can have: see slipd_frames");
    source_.reset(made);
    values_ = std::size_t{frames.taxels} * static_cast<std::size_t>(frames.axes);
  }

  // Throw Error, also SLIPD_TIMEOUT and SLIPD_DISCONNECTED; the next call connects again.
  void connect(double timeout_s = 1) { check(slipd_source_connect(source_.get(), timeout_s)); }
  // taxels x axes values. `time_ns` and `sequence` as in slipd.h.
  void push(std::span<const float> values, std::int64_t time_ns = 0, std::uint64_t sequence = 0,
            double timeout_s = 1) {
    if (values.size() != values_)
      throw Error(SLIPD_INVALID, "the frame has " + std::to_string(values.size()) + " values; expected " +
                                     std::to_string(values_) + ", taxels x axes");
    check(slipd_push(source_.get(), values.data(), time_ns, sequence, timeout_s));
  }

 private:
  void check(int code) const {
    if (code != SLIPD_DONE) throw Error(code, slipd_source_error(source_.get()));
  }
  struct Close {
    void operator()(slipd_source* source) const noexcept { slipd_source_close(source); }
  };
  std::unique_ptr<slipd_source, Close> source_;
  std::size_t values_ = 0;
};

}  // namespace slipd::client
