#include "drivers/replay/playlist.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

namespace slipd::replay {
namespace {

constexpr double kUnknownRateHz = 100;
constexpr std::int64_t kLongestPauseNs = 3600 * std::int64_t{1000000000};
constexpr std::int64_t kWidestGap = std::int64_t{1} << 32;

std::vector<std::filesystem::path> files_of(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) return {path};
  std::vector<std::filesystem::path> files;
  for (std::filesystem::directory_iterator entry(path, error), none; !error && entry != none;
       entry.increment(error)) {
    const auto name = entry->path().filename().string();
    const auto kind = entry->path().extension();
    if (name.front() != '.' && (kind == ".csv" || kind == ".cbor" || kind == ".rec" || kind == ".slipd"))
      files.push_back(entry->path());
  }
  if (error) throw DriverError(path.string() + ": " + error.message());
  if (files.empty())
    throw DriverError(path.string() + ": a folder without any .csv, .cbor, .rec or .slipd to play");
  std::sort(files.begin(), files.end());
  return files;
}

// The mean of a file's first frames, as Calibration::bias. Frames with a value that is not finite do not
// count.
std::vector<float> measure_zero(FrameSource& source, const SensorSetup& sensor, double seconds) {
  const std::size_t taxels = sensor.layout.size();
  std::vector<float> memory(3 * taxels);
  const std::span<float> all(memory);
  FrameSlot slot;
  slot.normal_pa = all.first(taxels);
  slot.shear_x_pa = all.subspan(taxels, taxels);
  slot.shear_y_pa = all.last(taxels);
  std::vector<double> sums(3 * taxels);
  std::size_t frames = 0;
  std::optional<std::int64_t> first_ns;
  const auto length_ns = static_cast<std::int64_t>(seconds * 1e9);
  for (ReadOutcome outcome = source.next(slot);
       outcome != ReadOutcome::end && outcome != ReadOutcome::damaged; outcome = source.next(slot)) {
    if (outcome != ReadOutcome::frame) continue;
    if (!first_ns) first_ns = slot.time_ns;
    if (slot.time_ns - *first_ns >= length_ns) break;
    ++frames;
    for (std::size_t i = 0; i < taxels; ++i) {
      sums[3 * i] += static_cast<double>(slot.shear_x_pa[i]);
      sums[3 * i + 1] += static_cast<double>(slot.shear_y_pa[i]);
      sums[3 * i + 2] += static_cast<double>(slot.normal_pa[i]);
    }
  }
  source.rewind();
  if (frames == 0)
    throw DriverError("sensor \"" + sensor.name +
                      "\": replay's zero_from_s finds no frame at the beginning of " +
                      sensor.options.value("file", ""));
  std::vector<float> bias(3 * taxels);
  for (std::size_t i = 0; i < bias.size(); ++i)
    bias[i] = static_cast<float>(sums[i] / static_cast<double>(frames));
  return bias;
}

}  // namespace

Playlist::Playlist(const SensorSetup& sensor, Options options) : options_(std::move(options)) {
  for (const auto& file : files_of(options_.file)) sources_.push_back(open_source(file, sensor));
  for (const auto& source : sources_) {
    Calibration& calibration = calibrations_.emplace_back(options_.calibration);
    if (options_.zero_from_s > 0) calibration.bias = measure_zero(*source, sensor, options_.zero_from_s);
  }
  const double rate = rate_hz() > 0 ? rate_hz() : kUnknownRateHz;
  period_ns_ = std::max<std::int64_t>(1, std::llround(1e9 / rate));
  time_ns_ = -period_ns_;
}

bool Playlist::zeroed() const noexcept {
  return std::all_of(sources_.begin(), sources_.end(), [](const auto& source) { return source->zeroed(); });
}

bool Playlist::next_file() noexcept {
  if (current_ + 1 == sources_.size()) {
    if (!options_.loop || !frames_in_round_) return false;
    frames_in_round_ = false;
    current_ = 0;
  } else {
    ++current_;
  }
  sources_[current_]->rewind();
  first_of_file_ = true;
  return true;
}

bool Playlist::any_damage() const noexcept {
  return std::any_of(sources_.begin(), sources_.end(),
                     [](const auto& source) { return source->has_fault(); });
}

std::string Playlist::fault() const {
  const auto found =
      std::find_if(sources_.begin(), sources_.end(), [](const auto& source) { return source->has_fault(); });
  return found == sources_.end() ? std::string() : (*found)->fault();
}

ReadOutcome Playlist::next(FrameSlot& out) noexcept {
  ReadOutcome status = sources_[current_]->next(out);
  while (status == ReadOutcome::end && next_file()) status = sources_[current_]->next(out);
  if (status == ReadOutcome::end && any_damage()) return ReadOutcome::damaged;
  if (status != ReadOutcome::frame) return status;
  // Unsigned differences cannot overflow, whatever a damaged file holds; the casts restore the sign.
  const auto step_ns = first_of_file_ ? period_ns_
                                      : static_cast<std::int64_t>(static_cast<std::uint64_t>(out.time_ns) -
                                                                  static_cast<std::uint64_t>(file_time_ns_));
  const auto frames = first_of_file_ ? 1 : static_cast<std::int64_t>(out.sequence - file_sequence_);
  if (step_ns <= 0) ++unrisen_;
  first_of_file_ = false;
  frames_in_round_ = true;
  file_time_ns_ = out.time_ns;
  file_sequence_ = out.sequence;
  out.time_ns = time_ns_ += std::clamp<std::int64_t>(step_ns, 1, kLongestPauseNs);
  out.sequence = sequence_ += static_cast<std::uint64_t>(std::clamp<std::int64_t>(frames, 1, kWidestGap));
  if (out.device_time_ns < 0) out.device_time_ns = out.time_ns;
  const bool finite = calibrations_[current_].apply(out);
  // A displacement that is not finite is a point that was not seen.
  return finite || sensor_class() == SensorClass::displacement ? ReadOutcome::frame : ReadOutcome::corrupt;
}

}  // namespace slipd::replay
