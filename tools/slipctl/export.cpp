#include "tools/slipctl/export.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "bridges/ros2/mcap/mcap_writer.hpp"
#include "bridges/ros2/messages/cdr.hpp"
#include "bridges/ros2/messages/sensor_messages.hpp"
#include "core/estimate/estimate.hpp"
#include "core/recording/recording.hpp"
#include "tools/slipctl/client.hpp"

namespace slipctl {
namespace {

namespace ros2 = slipd::ros2;
using slipd::RecordedEntry;
using slipd::RecordedEstimate;
using slipd::RecordingHeader;

// One frame of a recording with what was estimated from it.
struct RecordedFrame {
  slipd::FrameSlot slot;
  std::optional<RecordedEstimate> estimate;
  std::int64_t realtime_ns = 0;
};

// Where frames of a recording go.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  virtual void take(const RecordedFrame& frame) = 0;
  virtual void finish() = 0;
};

ros2::SlipEstimate estimate_message(const RecordedEstimate& from, const ros2::Header& header,
                                    const RecordedFrame& frame, bool simulated) {
  ros2::SlipEstimate out;
  out.header = header;
  out.name = header.frame_id;
  out.state = from.state;
  out.alert = from.alert;
  out.sliding = from.sliding;
  out.simulated = simulated;
  out.seq = frame.slot.sequence;
  out.age = 0;
  if (from.state == ros2::SlipEstimate::kOk) out.margin = from.gamma;
  out.margin_sigma = from.sigma;
  out.margin_low = from.gamma_low;
  out.friction = from.friction;
  out.friction_sigma = from.friction_sigma;
  out.normal_force = from.normal_n;
  out.shear_force = from.shear_n;
  out.shear_force_x = from.shear_x_n;
  out.shear_force_y = from.shear_y_n;
  out.torque = from.torque_nm;
  out.torque_sigma = from.torque_sigma_nm;
  out.center_x = from.center_x_m;
  out.center_y = from.center_y_m;
  out.radius = from.radius_m;
  out.time_to_slip = from.time_to_slip_s;
  out.grip_increase = from.grip_increase_n;
  out.grip_increase_sigma = from.grip_increase_sigma_n;
  out.sliding_for = from.sliding_for_s;
  return out;
}

class McapSink final : public FrameSink {
 public:
  McapSink(const ExportOptions& options, const RecordingHeader& recording)
      : writer_(options.mcap, {.library = "slipctl " SLIPD_VERSION, .overwrite = options.force}),
        recording_(recording) {
    header_.frame_id = recording.sensor;
    const auto topic = [&](std::string_view leaf) {
      return ros2::topic_of(options.prefix, recording.sensor, leaf);
    };
    wrench_ = writer_.add_channel<ros2::WrenchStamped>(topic("wrench"));
    taxels_ = writer_.add_channel<ros2::PointCloud2>(topic("taxels"));
    margin_ = writer_.add_channel<ros2::Float32>(topic("margin"));
    margin_low_ = writer_.add_channel<ros2::Float32>(topic("margin_low"));
    estimate_ = writer_.add_channel<ros2::SlipEstimate>(topic("estimate"));
    alert_ = writer_.add_channel<ros2::SlipEstimate>(topic("alert"));
    if (recording.simulated) truth_ = writer_.add_channel<ros2::Float32>(topic("truth_margin"));
  }

  void take(const RecordedFrame& frame) override {
    const slipd::FrameSlot& slot = frame.slot;
    const ros2::Taxels taxels{recording_.layout.x_m(), recording_.layout.y_m(), slot.normal_pa,
                              slot.shear_x_pa, slot.shear_y_pa};
    header_.stamp = ros2::time_of(frame.realtime_ns);
    fill_cloud(header_, taxels, cloud_);
    put(taxels_, frame, cloud_);
    if (truth_) put(*truth_, frame, ros2::Float32{.data = static_cast<float>(slot.truth.gamma)});
    if (frame.estimate && frame.estimate->is_whole()) {
      const auto estimate = estimate_message(*frame.estimate, header_, frame, recording_.simulated);
      put(wrench_, frame, ros2::wrench_of(estimate));
      put_estimate(frame, estimate);
      return;
    }
    ros2::WrenchStamped wrench;
    wrench.header = header_;
    if (recording_.zeroed) {
      wrench.wrench = ros2::wrench_of(taxels, recording_.layout.area_m2(),
                                      recording_.sensor_class != slipd::SensorClass::normal);
    }
    put(wrench_, frame, wrench);
    if (!frame.estimate) return;
    auto estimate = estimate_message(*frame.estimate, header_, frame, recording_.simulated);
    estimate.shear_force_x = wrench.wrench.force.x;
    estimate.shear_force_y = wrench.wrench.force.y;
    put_estimate(frame, estimate);
  }
  void finish() override { writer_.close(); }

 private:
  void put_estimate(const RecordedFrame& frame, const ros2::SlipEstimate& estimate) {
    put(margin_, frame, margin_of(estimate));
    put(margin_low_, frame, margin_low_of(estimate));
    put(estimate_, frame, estimate);
    if (estimate.alert != last_alert_) put(alert_, frame, estimate);
    last_alert_ = estimate.alert;
  }
  template <ros2::Message T>
  void put(std::uint16_t channel, const RecordedFrame& frame, const T& message) {
    encode(message, bytes_);
    writer_.write(channel, static_cast<std::uint64_t>(std::max<std::int64_t>(0, frame.realtime_ns)), bytes_);
  }

  ros2::McapWriter writer_;
  const RecordingHeader& recording_;
  ros2::Header header_;
  ros2::PointCloud2 cloud_;
  std::vector<std::uint8_t> bytes_;
  std::uint16_t wrench_ = 0, taxels_ = 0, margin_ = 0, margin_low_ = 0, estimate_ = 0, alert_ = 0;
  std::optional<std::uint16_t> truth_;
  std::uint8_t last_alert_ = ros2::SlipEstimate::kAlertUnknown;
};

// The name of a code as on the socket; "" if it is unknown.
std::string_view name_of(const RecordedEntry& entry, std::uint8_t code) {
  if (code == RecordedEstimate::kNoCode) return {};
  if (entry.code == &RecordedEstimate::state) return to_string(static_cast<slipd::State>(code));
  if (entry.code == &RecordedEstimate::alert) return to_string(static_cast<slipd::Alert>(code));
  if (entry.code == &RecordedEstimate::alert_cause) return to_string(static_cast<slipd::AlertCause>(code));
  if (entry.code == &RecordedEstimate::method) return to_string(static_cast<slipd::Method>(code));
  if (entry.code == &RecordedEstimate::health) return to_string(static_cast<slipd::Health>(code));
  const auto sliding = static_cast<slipd::Sliding>(code);
  return sliding <= slipd::Sliding::rotation ? to_string(sliding) : std::string_view();
}

// Columns of taxels are those that the driver `replay` reads.
class CsvSink final : public FrameSink {
 public:
  CsvSink(const ExportOptions& options, const RecordingHeader& recording) : file_(options.csv) {
    if (!options.force && std::filesystem::exists(file_))
      throw ClientError(file_ + ": exists already; name another file, or give --force");
    out_.open(file_);
    if (!out_) throw ClientError("cannot write " + file_);
    line_ = "time,realtime_ns,seq";
    for (const RecordedEntry& entry : slipd::kRecordedEntries) (line_ += ',') += entry.key;
    line_ += ",truth_gamma,truth_friction";
    for (std::size_t i = 1; i <= recording.layout.size(); ++i) {
      for (const char axis : {'x', 'y', 'z'}) line_ += ",txl" + std::to_string(i) + "_" + axis;
    }
    end_line();
  }

  void take(const RecordedFrame& frame) override {
    const slipd::FrameSlot& slot = frame.slot;
    if (!first_ns_) first_ns_ = slot.time_ns;
    add(1e-9 * static_cast<double>(slot.time_ns - *first_ns_));
    add(frame.realtime_ns);
    add(slot.sequence);
    for (const RecordedEntry& entry : slipd::kRecordedEntries) add_entry(entry, frame.estimate);
    add(slot.truth.gamma);
    add(slot.truth.friction);
    for (std::size_t i = 0; i < slot.normal_pa.size(); ++i) {
      for (const float value : {slot.shear_x_pa[i], slot.shear_y_pa[i], slot.normal_pa[i]}) add(value);
    }
    end_line();
  }
  void finish() override {
    out_.close();
    if (!out_) throw ClientError("cannot write " + file_);
  }

 private:
  // A margin is a number in state ok only.
  void add_entry(const RecordedEntry& entry, const std::optional<RecordedEstimate>& estimate) {
    const bool held_back = entry.number == &RecordedEstimate::gamma && estimate &&
                           estimate->state != static_cast<std::uint8_t>(slipd::State::ok);
    if (!estimate || held_back) return add(std::string_view());
    if (entry.number != nullptr) return add((*estimate).*entry.number);
    add(name_of(entry, (*estimate).*entry.code));
  }
  // The shortest text that is read back as the same number. An unknown number is an empty field.
  template <class T>
  requires std::is_arithmetic_v<T>
  void add(T value) {
    if constexpr (std::is_floating_point_v<T>) {
      if (std::isnan(value)) return add(std::string_view());
    }
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value);
    add(std::string_view(text.data(), end.ptr));
  }
  void add(std::string_view field) {
    if (any_) line_ += ',';
    any_ = true;
    line_ += field;
  }
  void end_line() {
    line_ += '\n';
    out_ << line_;
    line_.clear();
    any_ = false;
  }

  std::string file_;
  std::ofstream out_;
  std::string line_;
  bool any_ = false;  // a field is in the line
  std::optional<std::int64_t> first_ns_;
};

std::uint64_t export_frames(const std::string& file, slipd::RecordingReader& reader,
                            const std::vector<std::unique_ptr<FrameSink>>& sinks) {
  const RecordingHeader& header = reader.header();
  const std::size_t taxels = header.layout.size();
  std::vector<float> normal(taxels);
  std::vector<float> x(taxels);
  std::vector<float> y(taxels);
  RecordedFrame frame;
  frame.slot.normal_pa = normal;
  frame.slot.shear_x_pa = x;
  frame.slot.shear_y_pa = y;
  std::uint64_t frames = 0;
  bool is_old = false;
  while (reader.next_frame(frame.slot, &frame.estimate) == slipd::RecordingReader::Status::frame) {
    frame.realtime_ns = header.start_realtime_ns + frame.slot.time_ns - header.start_monotonic_ns;
    for (const auto& sink : sinks) sink->take(frame);
    is_old = is_old || (frame.estimate && !frame.estimate->is_whole());
    ++frames;
  }
  for (const auto& sink : sinks) sink->finish();
  if (is_old)
    std::cerr
        << "slipctl: " << file
        << ": its estimates are those of an older slipd, which did not record everything: shear components "
           "are sums of the taxels, the lower bound, place, grip and time to slip are unknown\n";
  return frames;
}

}  // namespace

bool export_recording(const ExportOptions& options) try {
  slipd::RecordingReader reader(options.file);
  std::vector<std::unique_ptr<FrameSink>> sinks;
  if (!options.mcap.empty()) sinks.push_back(std::make_unique<McapSink>(options, reader.header()));
  if (!options.csv.empty()) sinks.push_back(std::make_unique<CsvSink>(options, reader.header()));
  if (export_frames(options.file, reader, sinks) == 0)
    throw ClientError(options.file + ": a recording without a frame" +
                      (reader.has_fault() ? "; " + reader.fault() : ""));
  if (!reader.has_fault()) return true;
  std::cerr << "slipctl: " << reader.fault() << "; the rest is exported\n";
  return false;
} catch (const ClientError&) {
  throw;
} catch (const std::exception& error) {
  throw ClientError(error.what());
}

}  // namespace slipctl
