// Recordings that clients requested. Each has a writer thread of its own, so that a slow disk blocks nobody
// else. A thread that waits for a descriptor of a client beyond all limits is left behind: no stop and no
// reload waits for it.
#pragma once

#include <asio/io_context.hpp>
#include <functional>
#include <list>
#include <memory>
#include <stdexcept>
#include <string>

#include "core/storage/unique_fd.hpp"
#include "daemon/board/board.hpp"

namespace slipd {

// How a recording ended.
struct RecordingResult {
  // Frames written.
  std::uint64_t frames = 0;
  // Frames that did not fit into the queue because the disk or the reader was too slow.
  std::uint64_t missed = 0;
  // Size of the recording.
  std::uint64_t bytes = 0;
  // Duration, s.
  double seconds = 0;
  // Why it ended early, for people; empty: it did not.
  std::string trouble;
};

// Thrown by Recorder::start; nothing was recorded. what() says why.
class RecordingRefused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The given file cannot be written.
class UnfitFile : public RecordingRefused {
 public:
  using RecordingRefused::RecordingRefused;
};

// Not thread-safe. Called from one thread: io.
class Recorder {
 public:
  // `io` outlives it.
  explicit Recorder(asio::io_context& io);
  // As end_all.
  ~Recorder();

  // Ends all recordings early. What they have is written before it returns, as far as 0.3 s allow; no
  // SensorStatus is used afterwards. False: a thread still waits for a client's descriptor. Then neither this
  // object nor its io_context may be destroyed; the process may only end.
  bool end_all();

  // Records frames of a sensor into `file` for `seconds`, above 0. `done` is called in the io thread at the
  // end. Setting `cancelled` ends it early without trouble. Throws UnfitFile if `file` is not open for
  // writing, or is no regular file, pipe or socket; RecordingRefused if the sensor is being recorded, if its
  // layout is not known yet, or if other recordings take all memory or threads that there are for them.
  void start(SensorStatus& status, UniqueFd file, double seconds,
             std::shared_ptr<std::atomic<bool>> cancelled, std::function<void(const RecordingResult&)> done);

 private:
  struct Job;
  struct Running;
  static RecordingResult write(Job& job);
  void ended(const Job* job, const RecordingResult& result);
  std::size_t queue_frames(std::size_t taxels) const;
  asio::io_context& io_;
  std::list<Running> running_;
  std::list<std::shared_ptr<Job>> left_behind_;  // until their threads end
};

}  // namespace slipd
