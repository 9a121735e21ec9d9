// The files of one sensor as one stream: played one after another and, with the option `loop`, again from the
// first. Sequence and time continue from file to file. It reads no clock: time_ns counts recorded time from 0
// at the first frame.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "drivers/replay/options.hpp"
#include "drivers/replay/source.hpp"

namespace slipd::replay {

class Playlist {
 public:
  // Opens every file, so that an unsuitable one is refused at once. Throws DriverError.
  Playlist(const SensorSetup& sensor, Options options);

  // Acquire thread; allocates nothing. In `out`, sequence and time_ns rise strictly. Gaps in the recorded
  // sequence are kept, and so are pauses up to an hour; where the recorded clock stood or went back, time
  // advances by 1 ns. device_time_ns is the recorded one, or else recorded time. Values are in Pa. corrupt: a
  // frame with a value that is not finite was skipped, or a damaged block of a recording. damaged: the
  // present file cannot be read on, or it is the end and a file had damaged blocks; see fault().
  ReadOutcome next(FrameSlot& out) noexcept;
  // What is damaged in the first damaged file, and where; empty: nothing that was met so far.
  std::string fault() const;
  // Frames so far whose recorded time was not later than that of the frame before.
  std::uint64_t unrisen() const noexcept { return unrisen_; }

  std::size_t files() const noexcept { return sources_.size(); }
  double rate_hz() const noexcept { return sources_.front()->rate_hz(); }
  SensorClass sensor_class() const noexcept { return sources_.front()->sensor_class(); }
  bool zeroed() const noexcept;  // all of the files are

 private:
  bool next_file() noexcept;  // false: there is none
  bool any_damage() const noexcept;

  std::vector<std::unique_ptr<FrameSource>> sources_;
  std::vector<Calibration> calibrations_;  // of each source
  Options options_;
  std::int64_t period_ns_;  // between the last frame of a file and the first of the next
  std::size_t current_ = 0;
  bool first_of_file_ = true;
  bool frames_in_round_ = false;             // false: a loop over empty files ends
  std::int64_t file_time_ns_ = 0, time_ns_;  // of the last frame, in the file and as returned
  std::uint64_t file_sequence_ = 0, sequence_ = 0;
  std::uint64_t unrisen_ = 0;
};

}  // namespace slipd::replay
