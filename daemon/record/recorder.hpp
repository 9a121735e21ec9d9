// Recordings that clients requested. Each has a writer thread of its own, so that a slow disk blocks nobody
// else.
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
  // Frames that did not fit into the queue because the disk was too slow.
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
  // Ends all recordings; what they have is written before it returns.
  ~Recorder();

  // Ends all recordings early. When it returns, what they have is written, and no SensorStatus is used.
  void end_all();

  // Records frames of a sensor into `file` for `seconds`, above 0. `done` is called in the io thread at the
  // end. Setting `cancelled` ends it early without trouble. Throws UnfitFile if `file` is not open for
  // writing, RecordingRefused if the sensor is being recorded or its layout is not known yet.
  void start(SensorStatus& status, UniqueFd file, double seconds,
             std::shared_ptr<std::atomic<bool>> cancelled, std::function<void(const RecordingResult&)> done);

 private:
  struct Job;
  static RecordingResult write(Job& job);
  asio::io_context& io_;
  std::atomic<bool> stop_{false};  // set by io, read by writers; no other memory is read because of it
  std::list<std::unique_ptr<Job>> jobs_;
};

}  // namespace slipd
