// The flight recorder: keeps each sensor's last seconds of frames and estimates in memory. On a slip alert or
// on request it waits as many seconds more and writes all of it as a recording, which the driver `replay`
// plays. A thread of its own, with normal scheduling, takes frames from queues that acquire fills and
// estimates from queues that io fills, so that neither waits for it or for the disk.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "config/settings.hpp"
#include "daemon/board/board.hpp"
#include "daemon/record/frame_history.hpp"
#include "daemon/record/recordings_folder.hpp"
#include "daemon/record/request_rate.hpp"
#include "daemon/rt/thread.hpp"

namespace slipd {

// How a recording of one sensor ended.
struct FlightOutcome {
  // The recordings of this sensor that were begun to be written, with this one; 0: none was.
  std::uint64_t number = 0;
  // The recording; empty: there is none.
  std::string file;
  // Why there is none, for people; empty: there is one.
  std::string trouble;
};

// Thread-safe; each function names its callers.
class FlightRecorder {
 public:
  // Called from one thread: io. `board` outlives it. Throws std::runtime_error if there is no folder for
  // recordings; see recordings_directory.
  FlightRecorder(const RecorderSettings& settings, Board& board);
  // Called from one thread: io. Requests a stop and joins, unless join_until has.
  ~FlightRecorder();
  FlightRecorder(const FlightRecorder&) = delete;
  FlightRecorder& operator=(const FlightRecorder&) = delete;

  // Called from one thread: io. Starts the thread. Once.
  void start();
  // Called from one thread: io. Returns at once. The thread writes triggered recordings, with the frames that
  // there are, and ends: as late as the disk lets it.
  void request_stop() noexcept { stop_.store(true, std::memory_order_relaxed); }
  // Called from one thread: io. See Thread::join_until.
  bool join_until(std::chrono::steady_clock::time_point deadline) { return thread_.join_until(deadline); }

  // Why a recording is made; part of its file's name, and a kind of file with a limit of its own.
  enum class Reason : std::uint8_t { none, request, slip };

  // Called from one thread: io. Demands a recording around the present moment. Without effect while one of
  // this sensor is pending, unless that was requested and this one is of a slip: then it becomes the slip's.
  void trigger(std::size_t sensor, Reason reason) noexcept;
  // Called from one thread: io. As trigger, by a client. The number of the recording, as in FlightOutcome;
  // nothing: clients have requested too many of this sensor (ten at once, one a second in the long run).
  std::optional<std::uint64_t> request(std::size_t sensor) noexcept;

  // How the sensor's last recording ended. Called from any thread but real-time ones: it locks.
  FlightOutcome outcome(std::size_t sensor) const;

  // Called from one thread: io. Adds an estimate to its frame. One that does not fit into the queue is
  // missing in the recording.
  void add_estimate(std::size_t sensor, const Estimate& estimate) noexcept;

  // Where recordings are. Called from any thread.
  const std::filesystem::path& folder() const noexcept { return folder_.path(); }
  // Recordings written since the start: an outcome() read afterwards knows of them. Called from any thread.
  std::uint64_t files_written() const noexcept { return files_written_.load(std::memory_order_acquire); }
  // Recordings that could not be written, likewise, and other failures. Called from any thread.
  std::uint64_t failures() const noexcept { return failures_.load(std::memory_order_acquire); }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kRequestsPerSecond = 1;
  static constexpr double kRequestsAtOnce = 10;
  struct TimedEstimate {
    std::int64_t time_ns = 0;  // of its frame
    RecordedEstimate estimate;
  };
  struct Track {
    SensorStatus* status = nullptr;
    std::unique_ptr<FrameQueue> queue;  // attached to the status's flight_tap
    boost::lockfree::spsc_queue<TimedEstimate, boost::lockfree::capacity<2048>>
        estimates_in;  // io → this thread
    std::unique_ptr<FrameHistory> history;
    std::optional<TaxelLayout> layout;
    std::atomic<Reason> trigger_reason{Reason::none};  // io → this thread; relaxed: no other memory with it
    Reason reason = Reason::none;      // of the pending recording, written at `due`; none: none is pending
    std::atomic<bool> pending{false};  // whether `reason` is set; this thread → io; relaxed: as above
    RequestRate requests{kRequestsPerSecond, kRequestsAtOnce};  // used by io only
    Clock::time_point due;
    bool failure_logged = false;          // the present failure was logged
    std::atomic<std::uint64_t> begun{0};  // recordings; relaxed: a counter
    FlightOutcome outcome;                // of the last; guarded by outcomes_
  };
  void run();
  void process(Track& track, bool last);
  void follow_device(Track& track);
  static void drain_queues(Track& track);
  void write_if_due(Track& track, Clock::time_point now, bool last);
  void write(Track& track, bool last);
  void finish(Track& track, std::string file, std::string trouble);

  const RecorderSettings settings_;
  RecordingsFolder folder_;
  std::vector<std::unique_ptr<Track>> tracks_;
  mutable std::mutex outcomes_;
  std::atomic<bool> stop_{false};  // relaxed: no other memory is read because of it
  // Counted with release once the outcome stands, read with acquire before it: no count without its outcome.
  std::atomic<std::uint64_t> files_written_{0}, failures_{0};
  Thread thread_;
};

}  // namespace slipd
