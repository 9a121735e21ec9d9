// The files of one sensor as one stream: played one after another, again from the first if told to, with
// sequence and time going on across the seams. No clock of its own: time_ns counts recorded time from 0 at
// the first frame.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "drivers/replay/options.hpp"
#include "drivers/replay/source.hpp"

namespace slipd::replay {

class Playlist {
 public:
  // Opens every file there is, so that one which does not fit is refused now. Throws DriverError.
  Playlist(const SensorSetup& sensor, Options options);

  // Acquire thread; allocates nothing. `out`: sequence and time_ns strictly rising, gaps in the recorded
  // sequence kept (and pauses, up to an hour; a clock that stood or went back makes steps of 1 ns),
  // device_time_ns the recorded one or else recorded time; values in Pa. corrupt: a frame with a value that
  // is no finite number was passed over.
  Next next(FrameSlot& out) noexcept;
  std::string fault() const { return sources_[current_]->fault(); }

  std::size_t files() const noexcept { return sources_.size(); }
  double rate_hz() const noexcept { return sources_.front()->rate_hz(); }
  SensorClass sensor_class() const noexcept { return sources_.front()->sensor_class(); }
  bool zeroed() const noexcept;  // all of the files are

 private:
  bool turn_over() noexcept;  // to the next file; false: there is none

  std::vector<std::unique_ptr<FrameSource>> sources_;
  Options options_;
  std::int64_t period_ns_;  // between the last frame of a file and the first of the next
  std::size_t current_ = 0;
  bool first_of_file_ = true;
  bool frames_in_round_ = false;             // so that a loop over empty files ends
  std::int64_t file_time_ns_ = 0, time_ns_;  // of the last frame, as the file has it and as given out
  std::uint64_t file_sequence_ = 0, sequence_ = 0;
};

}  // namespace slipd::replay
