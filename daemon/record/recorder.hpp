// Recordings that clients have asked for: each has a writer thread of its own, so that a slow disk holds up
// nobody. io thread, but for the writers themselves.
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

struct RecordingResult {
  std::uint64_t frames = 0;
  std::uint64_t missed = 0;  // the disk was too slow for
  std::uint64_t bytes = 0;
  double seconds = 0;   // that it took
  std::string trouble;  // why it ended early; empty: it did not
};

// Thrown by Recorder::start before anything is recorded; what() says why.
class RecordingRefused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The file that was given cannot be recorded into.
class UnfitFile : public RecordingRefused {
 public:
  using RecordingRefused::RecordingRefused;
};

class Recorder {
 public:
  explicit Recorder(asio::io_context& io);
  ~Recorder();  // ends all recordings; what they have is on disk then

  // Ends all recordings early. What they have is on disk when it returns, and no sensor status is used any
  // more.
  void end_all();

  // Starts one into `file`. `done` is called in the io thread. `abandoned` ends it early, without trouble.
  // Throws UnfitFile for a descriptor that is not open for writing, RecordingRefused if the sensor is being
  // recorded or has no layout yet.
  void start(SensorStatus& status, UniqueFd file, double seconds,
             std::shared_ptr<std::atomic<bool>> abandoned, std::function<void(const RecordingResult&)> done);

 private:
  struct Job;
  static RecordingResult write(Job& job);
  asio::io_context& io_;
  std::atomic<bool> stop_{false};  // io sets it, writers look at it each round; nothing else goes with it
  std::list<std::unique_ptr<Job>> jobs_;
};

}  // namespace slipd
