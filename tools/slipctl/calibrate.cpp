#include "tools/slipctl/calibrate.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <vector>

#include "core/recording/recording.hpp"
#include "tools/slipctl/calibration/report.hpp"
#include "tools/slipctl/client.hpp"

namespace slipctl {
namespace {

using namespace calibration;
using json = nlohmann::ordered_json;

constexpr double kMmPerMetre = 1e3;

std::string instruction(Step step, const CalibrateOptions& options) {
  char text[320];
  const auto say = [&](const char* format, double force_n) {
    std::snprintf(text, sizeof text, format, force_n);
    return std::string(text);
  };
  switch (step) {
    case Step::zero:
      return "Lay the sensor flat, and let nothing touch it.";
    case Step::normal:
      return say("Put the weight of %.4g N on the middle of the sensor.", options.normal_n);
    case Step::shear_x:
      return say(
          "Let the weight of %.4g N pull along the sensor's +x: over a thread from something that is pressed "
          "or "
          "glued onto it, or with the sensor turned so that +x points down.",
          options.shear_n);
    case Step::shear_y:
      return say("The same with %.4g N along +y.", options.shear_n);
    case Step::corner:
      return say("Put the weight of %.4g N on the corner with the least x and the least y.",
                 options.normal_n);
    case Step::corner_x:
      return say("Put the weight of %.4g N on the corner with the greatest x and the least y.",
                 options.normal_n);
  }
  return {};
}

// The sums of one frame; nothing if a value is no number.
std::optional<FrameSums> sums_of(const slipd::FrameSlot& frame, const slipd::TaxelLayout& layout) {
  FrameSums sums;
  const double area_m2 = layout.area_m2();
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const double normal_n = area_m2 * static_cast<double>(frame.normal_pa[i]);
    sums.force_n[kX] += area_m2 * static_cast<double>(frame.shear_x_pa[i]);
    sums.force_n[kY] += area_m2 * static_cast<double>(frame.shear_y_pa[i]);
    sums.force_n[kNormal] += normal_n;
    sums.moment_nmm[0] += kMmPerMetre * layout.x_m()[i] * normal_n;
    sums.moment_nmm[1] += kMmPerMetre * layout.y_m()[i] * normal_n;
  }
  const auto finite = [](double value) { return std::isfinite(value); };
  if (!std::ranges::all_of(sums.force_n, finite)) return std::nullopt;
  return sums;
}

Pad pad_of(const slipd::RecordingHeader& header) {
  Pad pad{.sensor_class = header.sensor_class};
  const auto extent = [&](std::size_t axis, std::span<const double> places_m) {
    const auto [least, greatest] = std::ranges::minmax(places_m);
    pad.least_mm[axis] = kMmPerMetre * least;
    pad.greatest_mm[axis] = kMmPerMetre * greatest;
  };
  extent(0, header.layout.x_m());
  extent(1, header.layout.y_m());
  return pad;
}

// Reads a sensor of a running slipd.
class Scale {
 public:
  Scale(const CommonOptions& common, const CalibrateOptions& options)
      : options_(options), client_(common.socket) {
    const json answer = client_.call("sensors");
    std::string known;
    for (const json& sensor : answer.at("sensors")) {
      const auto name = sensor.at("name").get<std::string>();
      known += (known.empty() ? "" : ", ") + name;
      if (name != options.sensor) continue;
      driver_ = sensor.at("driver");
      if (!sensor.value("connected", false) || !sensor.value("receiving", true))
        throw ClientError(name + " sends no frames that can be used: slipctl status says why");
    }
    if (driver_.empty())
      throw ClientError("there is no sensor " + options.sensor + "; slipd has " +
                        (known.empty() ? "none" : known));
  }

  const std::string& driver() const { return driver_; }

  // Records the sensor for the time of one step. `subject`: what the recording says of it is set.
  Reading read(Subject& subject) {
    const UniqueFd file(::memfd_create("calibration", MFD_CLOEXEC));
    if (!file) throw ClientError("no memory for the frames of a step");
    client_.record(options_.sensor, options_.seconds, file.get());
    slipd::RecordingReader reader("/proc/self/fd/" + std::to_string(file.get()));
    const slipd::TaxelLayout& layout = reader.header().layout;
    subject.pad = pad_of(reader.header());
    subject.zeroed = reader.header().zeroed;
    std::vector<float> normal(layout.size()), x(layout.size()), y(layout.size());
    slipd::FrameSlot frame;
    frame.normal_pa = normal;
    frame.shear_x_pa = x;
    frame.shear_y_pa = y;
    std::vector<FrameSums> all;
    while (reader.next_frame(frame) == slipd::RecordingReader::Status::frame) {
      if (const auto sums = sums_of(frame, layout)) all.push_back(*sums);
    }
    if (all.size() < kLeastFrames) refuse_few(all.size());
    return reading_of(all);
  }

 private:
  [[noreturn]] void refuse_few(std::size_t frames) const {
    throw CalibrationError(options_.sensor + " gave " + std::to_string(frames) + " frames, and " +
                           std::to_string(kLeastFrames) +
                           " are needed: give more --seconds, or see slipctl status");
  }

  const CalibrateOptions& options_;
  RpcClient client_;
  std::string driver_;
};

// The steps of one sensor in a file, from one call to the next.
class StepFile {
 public:
  StepFile(std::string path, const std::string& sensor) : path_(std::move(path)), sensor_(sensor) {
    std::ifstream in(path_);
    if (!in) return;
    try {
      const json content = json::parse(in);
      if (content.at("sensor") != sensor)
        throw CalibrationError(path_ + " has steps of sensor " + content.at("sensor").get<std::string>() +
                               ": give another file for " + sensor);
      for (const auto& [name, reading] : content.at("steps").items()) {
        if (const auto step = step_of(name)) readings_[*step] = reading_from(reading);
      }
    } catch (const nlohmann::json::exception& wrong) {
      throw CalibrationError(path_ + ": no steps of a calibration: " + wrong.what());
    }
  }

  // Step zero begins a calibration anew.
  void keep(Step step, const Reading& reading) {
    if (step == Step::zero) readings_.clear();
    readings_[step] = reading;
    json steps = json::object();
    for (const auto& [each, read] : readings_) steps[std::string(to_string(each))] = to_json(read);
    std::ofstream out(path_);
    out << json{{"sensor", sensor_}, {"steps", steps}}.dump(1) << '\n';
    if (!out.flush()) throw ClientError("cannot write " + path_);
  }
  const Readings& readings() const { return readings_; }

 private:
  std::string path_, sensor_;
  Readings readings_;
};

void print(const CommonOptions& common, const Subject& subject, const CalibrateOptions& options,
           const Readings& readings) {
  const Weights weights{options.normal_n, options.shear_n};
  const Scales scales = scales_of(subject.pad, weights, readings);
  if (common.json)
    std::cout << calibration::to_json(subject, scales).dump() << '\n';
  else
    std::cout << report(subject, weights, scales);
}

bool is_wanted(Step step, const CalibrateOptions& options) {
  if (step == Step::shear_x || step == Step::shear_y) return options.shear_n > 0;
  if (step == Step::corner || step == Step::corner_x) return options.corner;
  return true;
}

void refuse_what_it_cannot(const Pad& pad, const CalibrateOptions& options) {
  if (options.shear_n > 0 && !pad.has_shear())
    throw CalibrationError(options.sensor + " measures no shear: leave --shear out");
  if (options.corner && pad.sensor_class == slipd::SensorClass::wrench)
    throw CalibrationError(options.sensor + " has no taxels: leave --corner out");
}

// Reads a step when the person has pressed Enter, again until it can be used.
Reading ask_for(Step step, Scale& scale, const CalibrateOptions& options, Subject& subject,
                const Readings& before) {
  for (;;) {
    std::cerr << instruction(step, options) << " Then press Enter: " << std::flush;
    if (std::string line; !std::getline(std::cin, line))
      throw ClientError("the input ended before step " + std::string(to_string(step)) +
                        "; in scripts use --step and --file");
    std::cerr << "reading for " << options.seconds << " s ..." << std::endl;
    const Reading reading = scale.read(subject);
    const auto zero = before.find(Step::zero);
    const std::string trouble = zero == before.end() ? "" : trouble_of(step, zero->second, reading);
    if (trouble.empty()) return reading;
    std::cerr << "  " << trouble << '\n';
  }
}

void lead(const CommonOptions& common, const CalibrateOptions& options, Scale& scale) {
  Subject subject{.sensor = options.sensor, .driver = scale.driver(), .pad = {}};
  Readings readings;
  for (const Step step : kSteps) {
    if (!is_wanted(step, options)) continue;
    readings[step] = ask_for(step, scale, options, subject, readings);
    refuse_what_it_cannot(subject.pad, options);
  }
  print(common, subject, options, readings);
}

// One step for a script; with the last one the result.
void one_step(const CommonOptions& common, const CalibrateOptions& options, Scale& scale) {
  Subject subject{.sensor = options.sensor, .driver = scale.driver(), .pad = {}};
  StepFile file(options.file, options.sensor);
  const Step step = step_of(options.step).value();
  const Reading reading = scale.read(subject);
  refuse_what_it_cannot(subject.pad, options);
  if (const auto zero = file.readings().find(Step::zero);
      step != Step::zero && zero != file.readings().end()) {
    if (const std::string trouble = trouble_of(step, zero->second, reading); !trouble.empty())
      throw CalibrationError(trouble);
  }
  file.keep(step, reading);
  const bool whole = std::ranges::all_of(
      kSteps, [&](Step each) { return !is_wanted(each, options) || file.readings().contains(each); });
  if (whole)
    print(common, subject, options, file.readings());
  else
    std::cerr << "step " << options.step << " is in " << options.file << '\n';
}

}  // namespace

double force_of(const std::string& text) {
  constexpr double kGravity = 9.80665;  // m/s^2, the standard one
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  std::string unit(end, text.data() + text.size());
  unit.erase(0, unit.find_first_not_of(' '));
  const double newton = unit == "g" ? 1e-3 * kGravity : unit == "kg" ? kGravity : unit == "N" ? 1 : 0;
  if (error != std::errc() || !(value > 0) || !std::isfinite(value) || newton == 0)
    throw std::invalid_argument("\"" + text +
                                "\" is no weight: expected a number above 0 with g, kg or N, such as 200g");
  return value * newton;
}

void calibrate(const CommonOptions& common, const CalibrateOptions& options) {
  Scale scale(common, options);
  if (options.step.empty())
    lead(common, options, scale);
  else
    one_step(common, options, scale);
}

}  // namespace slipctl
