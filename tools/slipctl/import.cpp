#include "tools/slipctl/import.hpp"

#include <fcntl.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <exception>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>
#include <system_error>

#include "bridges/feed_ros2/topic_profile.hpp"
#include "bridges/feed_ros2/topic_reader.hpp"
#include "bridges/ros2/mcap/mcap_reader.hpp"
#include "core/recording/recording.hpp"
#include "core/storage/unique_fd.hpp"
#include "schema/settings_error.hpp"
#include "tools/slipctl/client.hpp"

namespace slipctl {
namespace {

using slipd::feed::Outcome;
using slipd::feed_ros2::TopicProfile;

constexpr double kMetresPerMm = 1e-3;
constexpr std::size_t kAxes = 3;
constexpr mode_t kMode = 0644;

slipd::TaxelLayout grid_of(const ImportOptions& options) {
  unsigned columns = 0, rows = 0;
  const char* const end = options.grid.data() + options.grid.size();
  const auto first = std::from_chars(options.grid.data(), end, columns);
  const bool crossed = first.ec == std::errc() && first.ptr != end && *first.ptr == 'x';
  const auto second = crossed ? std::from_chars(first.ptr + 1, end, rows) : first;
  if (!crossed || second.ec != std::errc() || second.ptr != end || options.pitch_mm <= 0)
    throw ClientError("--grid is COLUMNSxROWS, such as 4x4, and needs --pitch-mm above 0");
  const double pitch_m = kMetresPerMm * options.pitch_mm;
  return columns * rows == 1 ? slipd::TaxelLayout::wrench(pitch_m)
                             : slipd::TaxelLayout::grid(columns, rows, pitch_m);
}

slipd::TaxelLayout taxels_of(const ImportOptions& options) {
  std::vector<double> x_m, y_m;
  std::istringstream list(options.taxels_mm);
  for (std::string place; list >> place;) {
    std::istringstream in(place);
    double x = 0, y = 0;
    char comma = 0;
    if (!(in >> x >> comma >> y) || comma != ',' || in.peek() != std::istringstream::traits_type::eof())
      throw ClientError("--taxels-mm is a list of places such as \"0,0 -6,0 6,0\"");
    x_m.push_back(kMetresPerMm * x);
    y_m.push_back(kMetresPerMm * y);
  }
  return slipd::TaxelLayout::scattered(std::move(x_m), std::move(y_m));
}

slipd::TaxelLayout layout_of(const ImportOptions& options) {
  if (options.grid.empty() == options.taxels_mm.empty())
    throw ClientError("give the layout of the sensor: --grid and --pitch-mm, or --taxels-mm");
  return options.grid.empty() ? taxels_of(options) : grid_of(options);
}

// From the message's values to Pa.
std::array<float, kAxes> scale_of(const ImportOptions& options, const TopicProfile& profile,
                                  const slipd::TaxelLayout& layout) {
  if (!options.scale.empty() && options.scale.size() != kAxes)
    throw ClientError("--scale is three numbers: of x, y and z");
  const bool is_force = profile.frames.unit == SLIPD_UNIT_N;
  if (!is_force && profile.frames.unit != SLIPD_UNIT_PA && options.scale.empty())
    throw ClientError(
        "the profile's values are no pressures, and a recording has Pa: give --scale, from a calibration");
  std::array<float, kAxes> scale{1, 1, 1};
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    if (!options.scale.empty()) scale.at(axis) = static_cast<float>(options.scale[axis]);
    if (is_force) scale.at(axis) /= static_cast<float>(layout.area_m2());
  }
  return scale;
}

// What became of the messages.
struct Account {
  std::uint64_t frames = 0, corrupt = 0, repeated = 0, other = 0;
  std::string why;  // of the last one that became no frame
};

// Frames of one topic → the recording.
class Import {
 public:
  Import(const ImportOptions& options, const TopicProfile& profile)
      : options_(options),
        profile_(profile),
        layout_(layout_of(options)),
        scale_(scale_of(options, profile, layout_)),
        reader_(profile),
        normal_(layout_.size()),
        shear_x_(layout_.size()),
        shear_y_(layout_.size()) {
    slot_.normal_pa = normal_;
    slot_.shear_x_pa = shear_x_;
    slot_.shear_y_pa = shear_y_;
  }

  std::size_t taxels() const noexcept { return layout_.size(); }
  const Account& account() const noexcept { return account_; }

  void take(const slipd::ros2::McapMessage& message) {
    const auto log_ns = static_cast<std::int64_t>(message.log_ns);
    slipd::feed::Reading reading;
    const Outcome outcome =
        reader_.read({{}, message.data, static_cast<std::int64_t>(message.publish_ns)}, reading);
    if (outcome != Outcome::frame) {
      ++(outcome == Outcome::corrupt ? account_.corrupt : account_.other);
      account_.why = reader_.why();
      return;
    }
    const std::int64_t time_ns = reading.sequence ? static_cast<std::int64_t>(*reading.sequence) : log_ns;
    if (last_ns_ && time_ns <= *last_ns_) {
      ++account_.repeated;
      account_.why = "its time does not rise";
      return;
    }
    last_ns_ = time_ns;
    put(reading.values, time_ns);
  }

  // Throws ClientError.
  void finish() {
    if (writer_) check(writer_->finish());
  }

 private:
  void open(std::int64_t begin_ns) {
    const int flags = O_WRONLY | O_CREAT | O_CLOEXEC | (options_.force ? O_TRUNC : O_EXCL);
    fd_ = slipd::UniqueFd(::open(options_.out.c_str(), flags, kMode));
    if (!fd_ && errno == EEXIST)
      throw ClientError(options_.out + ": exists already; name another file, or give --force");
    if (!fd_) check(std::error_code(errno, std::generic_category()));
    begin_ns_ = begin_ns;
    const slipd::SensorClass kind = profile_.frames.axes == 1 ? slipd::SensorClass::normal
                                    : layout_.size() == 1     ? slipd::SensorClass::wrench
                                                              : slipd::SensorClass::array3;
    writer_.emplace(fd_.get(), slipd::RecordingHeader{.sensor = options_.sensor,
                                                      .sensor_class = kind,
                                                      .layout = layout_,
                                                      .rate_hz = profile_.frames.rate_hz,
                                                      .simulated = false,
                                                      .start_realtime_ns = begin_ns,
                                                      .start_monotonic_ns = 0,
                                                      .description = profile_.topic + " of " + options_.file,
                                                      .zeroed = profile_.frames.zero == SLIPD_ZERO_ZERO});
  }

  void put(const std::vector<float>& values, std::int64_t time_ns) {
    if (!writer_) open(time_ns);
    for (std::size_t taxel = 0; taxel < layout_.size(); ++taxel) {
      if (profile_.frames.axes == 1) {
        normal_[taxel] = values[taxel] * scale_[2];
        continue;
      }
      shear_x_[taxel] = values[kAxes * taxel] * scale_[0];
      shear_y_[taxel] = values[kAxes * taxel + 1] * scale_[1];
      normal_[taxel] = values[kAxes * taxel + 2] * scale_[2];
    }
    slot_.sequence = ++account_.frames;
    slot_.time_ns = time_ns - begin_ns_;
    slot_.device_time_ns = time_ns;
    check(writer_->append(slot_));
  }

  void check(const std::error_code& error) const {
    if (error) throw ClientError("cannot write " + options_.out + ": " + error.message());
  }

  const ImportOptions& options_;
  const TopicProfile& profile_;
  slipd::TaxelLayout layout_;
  std::array<float, kAxes> scale_;
  slipd::feed_ros2::TopicReader reader_;
  std::vector<float> normal_, shear_x_, shear_y_;
  slipd::FrameSlot slot_;
  slipd::UniqueFd fd_;
  std::optional<slipd::RecordingWriter> writer_;
  std::int64_t begin_ns_ = 0;
  std::optional<std::int64_t> last_ns_;
  Account account_;
};

// What the file has instead of the topic, for people.
std::string instead(const std::map<std::string, std::string, std::less<>>& topics) {
  std::string text;
  for (const auto& [topic, type] : topics) {
    if (!text.empty()) text += ", ";
    text.append(topic).append(" (").append(type).append(")");
  }
  return text.empty() ? "it has no messages" : "it has " + text;
}

TopicProfile profile_of(const ImportOptions& options, std::size_t taxels) {
  TopicProfile profile = slipd::feed_ros2::find_topic_profile(
      options.profile, {options.topic, options.frame_id, taxels == 1 ? 0 : taxels});
  if (profile.topic.empty()) throw ClientError("the profile names no topic: give --topic");
  if (profile.frames.taxels != taxels)
    throw ClientError("the layout has " + std::to_string(taxels) + " taxels, the profile " +
                      std::to_string(profile.frames.taxels));
  return profile;
}

bool tell(const ImportOptions& options, const Account& account, const std::string& fault) {
  std::cerr << "slipctl: " << options.out << ": " << account.frames << " frames";
  if (account.corrupt + account.repeated + account.other > 0)
    std::cerr << "; left out " << account.corrupt << " corrupt, " << account.repeated << " repeated, "
              << account.other << " other messages; the last one: " << account.why;
  std::cerr << '\n';
  if (!fault.empty()) std::cerr << "slipctl: " << fault << "; what is whole was read\n";
  return account.corrupt + account.repeated == 0 && fault.empty();
}

}  // namespace

bool import_recording(const ImportOptions& options) try {
  const TopicProfile profile = profile_of(options, layout_of(options).size());
  std::ifstream in(options.file, std::ios::binary);
  if (!in) throw ClientError("cannot read " + options.file);
  slipd::ros2::McapReader file(in, options.file);
  Import import(options, profile);
  std::map<std::string, std::string, std::less<>> topics;
  bool found = false;
  for (slipd::ros2::McapMessage message; file.next(message);) {
    topics.try_emplace(std::string(message.topic), message.schema);
    if (message.topic != profile.topic) continue;
    if (message.encoding != "cdr" || message.schema != message_name(profile.type))
      throw ClientError(options.file + ": " + profile.topic + " is of " + std::string(message.schema) + ", " +
                        std::string(message.encoding) + "; the profile says " + message_name(profile.type) +
                        ", cdr");
    found = true;
    import.take(message);
  }
  if (!found)
    throw ClientError(options.file + ": no message of " + profile.topic + "; " + instead(topics) +
                      (file.fault().empty() ? "" : "; " + file.fault()));
  if (import.account().frames == 0)
    throw ClientError(options.file +
                      ": none of the messages is a frame; the last one: " + import.account().why);
  import.finish();
  return tell(options, import.account(), file.fault());
} catch (const ClientError&) {
  throw;
} catch (const slipd::SettingsError& error) {
  std::string text;
  for (const std::string& problem : error.problems()) text += (text.empty() ? "" : "\n") + problem;
  throw ClientError(text);
} catch (const std::exception& error) {
  throw ClientError(error.what());
}

}  // namespace slipctl
