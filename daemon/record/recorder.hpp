// Recordings that clients requested. Each has a writer thread of its own, which sends it to a socket that the
// client reads from, and which waits for no reader longer than a second.
#pragma once

#include <asio/io_context.hpp>
#include <functional>
#include <list>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/storage/unique_fd.hpp"
#include "daemon/board/board.hpp"

namespace slipd {

// How a recording ended.
struct RecordingResult {
  // Frames sent.
  std::uint64_t frames = 0;
  // Frames that did not fit into the queue because the reader was too slow.
  std::uint64_t missed = 0;
  // Size of the recording.
  std::uint64_t bytes = 0;
  // Duration, s.
  double seconds = 0;
  // Why it ended early or is not whole, for people; empty: it is whole.
  std::string trouble;
  // Whether that is because the reader closed its end.
  bool left = false;
};

// Thrown by Recorder::start; nothing was recorded. what() says why.
class RecordingRefused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Not thread-safe. Called from one thread: io.
class Recorder {
 public:
  // `io` outlives it.
  explicit Recorder(asio::io_context& io);
  // As end_all.
  ~Recorder();

  // Ends all recordings early and calls their `done`. Takes at most a quarter of a second, whatever readers
  // do. No SensorStatus is used afterwards.
  void end_all();

  // Records frames of a sensor for `seconds`, above 0, into `socket`, a stream socket of AF_UNIX whose other
  // end is read from. `done` is called in the io thread at the end, never by this function. Setting
  // `cancelled` ends it early without trouble. Returns the recording's number, from 1. Throws
  // RecordingRefused if the sensor is being recorded, if its layout is not known yet, if other recordings
  // take all memory that there is for them, or if too many readers have left their recordings unread.
  std::uint64_t start(SensorStatus& status, UniqueFd socket, double seconds,
                      std::shared_ptr<std::atomic<bool>> cancelled,
                      std::function<void(std::uint64_t number, const RecordingResult&)> done);

 private:
  struct Job;
  void write(Job& job);
  void ended(std::uint64_t number);
  void finish(Job& job);
  std::size_t queue_frames(std::size_t taxels) const;
  asio::io_context& io_;
  std::list<std::unique_ptr<Job>> running_;
  std::uint64_t started_ = 0;
  std::vector<UniqueFd>
      unread_;  // ended, but not read to the end: what is under way counts as slipd's memory
};

}  // namespace slipd
