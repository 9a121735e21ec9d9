// One topic of the bridge: its writer, its rate, and its channel in the recording. One thread at a time.
#pragma once

#include <cstdint>
#include <string>

#include "bridges/ros2/dds/node.hpp"
#include "bridges/ros2/estimate_message.hpp"
#include "bridges/ros2/recorder.hpp"

namespace slipd::ros2 {

// `topics` of the settings.
struct TopicOptions {
  bool publish = true;
  // Most messages a second; 0: no limit.
  double rate_hz = 0;
  WriterOptions writer;
};

template <Message T>
class Output {
 public:
  // `node` and `recorder` must live longer. Throws DdsError, McapError.
  Output(Node& node, Recorder& recorder, const std::string& topic, const TopicOptions& options)
      : writer_(node, topic, options.writer),
        recorder_(recorder),
        channel_(recorder.channel<T>(topic)),
        period_ns_(options.rate_hz > 0 ? static_cast<std::int64_t>(1e9 / options.rate_hz) : 0) {}

  // Whether anything takes messages: a reader, or the recording. Any thread.
  bool wanted() const noexcept { return writer_.has_readers() || recorder_.records(); }
  // Readers take the writer for alive as long as WriterOptions::lease from now.
  void assert_alive() const noexcept { writer_.assert_alive(); }
  // Publishes what `make` returns, unless nothing takes it or the rate forbids it.
  template <class Make>
  void put(const Moment& now, const Make& make) {
    if (!wanted() || now.monotonic_ns < next_ns_) return;
    // The grid of the rate, so that the mean rate is right; anew after a pause.
    next_ns_ =
        next_ns_ + 2 * period_ns_ > now.monotonic_ns ? next_ns_ + period_ns_ : now.monotonic_ns + period_ns_;
    put_now(now, make);
  }
  // The same at any rate.
  template <class Make>
  void put_now(const Moment& now, const Make& make) {
    if (!wanted()) return;
    const T& message = make();
    if (writer_.has_readers()) writer_.write(message);
    if (recorder_.records()) recorder_.write(channel_, now.realtime_ns, message);
  }

 private:
  Writer<T> writer_;
  Recorder& recorder_;
  std::uint16_t channel_;
  std::int64_t period_ns_;
  std::int64_t next_ns_ = 0;
};

}  // namespace slipd::ros2
