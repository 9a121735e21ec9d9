// The flight recorder: holds each sensor's last seconds of frames and estimates in memory, and on an alert or
// on request writes them, with as many seconds after it, into a recording that the driver replay plays. One
// normal thread of its own takes the frames from queues that acquire fills and the estimates from queues that
// io fills, so that neither ever waits for it or for the disk.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <vector>

#include "config/settings.hpp"
#include "daemon/board/board.hpp"
#include "daemon/record/frame_history.hpp"
#include "daemon/record/recordings_folder.hpp"
#include "daemon/rt/thread.hpp"

namespace slipd {

class FlightRecorder {
 public:
  // Throws std::runtime_error if there is no place for recordings. `board` outlives it.
  FlightRecorder(const RecorderSettings& settings, Board& board);
  ~FlightRecorder();  // what is to be kept is written first, with the frames that there are
  FlightRecorder(const FlightRecorder&) = delete;
  FlightRecorder& operator=(const FlightRecorder&) = delete;

  void start();

  // io. Keeps what is around now; nothing new if that is about to happen anyhow. `reason`: a word for the
  // file's name.
  void keep(std::size_t sensor, const char* reason) noexcept;

  // io. Each estimate, as it is told; one that finds no room is missing in the recording.
  void note(std::size_t sensor, const Estimate& estimate) noexcept;

  const std::filesystem::path& folder() const noexcept { return folder_.path(); }
  std::uint64_t kept() const noexcept { return kept_.load(std::memory_order_relaxed); }
  std::uint64_t failed() const noexcept { return failed_.load(std::memory_order_relaxed); }

 private:
  using Clock = std::chrono::steady_clock;
  struct Noted {
    std::int64_t time_ns = 0;  // of its frame
    RecordedEstimate estimate;
  };
  struct Track {
    SensorStatus* status = nullptr;
    std::unique_ptr<FrameQueue> queue;                                          // attached to the panel's tap
    boost::lockfree::spsc_queue<Noted, boost::lockfree::capacity<2048>> noted;  // io → here
    std::unique_ptr<FrameHistory> history;
    std::optional<TaxelLayout> layout;
    std::atomic<const char*> asked{
        nullptr};                  // io → here; relaxed: a literal, nothing else is read on its word
    const char* reason = nullptr;  // under way: written at `due`
    Clock::time_point due;
    bool complained = false;  // of what fails still
  };
  void run();
  void attend(Track& track, bool last);
  void follow_device(Track& track);
  static void take(Track& track);
  void work(Track& track, Clock::time_point now, bool last);
  void write(Track& track);

  const RecorderSettings settings_;
  RecordingsFolder folder_;
  std::vector<std::unique_ptr<Track>> tracks_;
  std::atomic<bool> stop_{false};  // relaxed: a word of its own, and joining the thread orders the rest
  std::atomic<std::uint64_t> kept_{0}, failed_{0};  // relaxed: numbers of their own
  Thread thread_;
};

}  // namespace slipd
