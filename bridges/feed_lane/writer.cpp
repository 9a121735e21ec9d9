#include "bridges/feed_lane/writer.hpp"

#include <chrono>
#include <utility>

namespace slipd::feed {
namespace {

// Frames that wait for slipd. Fewer: a burst loses frames. More: memory, and frames that are too old anyway.
constexpr std::size_t kMostWaiting = 64;
// How long slipd may take for one frame, or to accept the connection.
constexpr double kSlipdPatienceS = 1;
// After a refusal, before slipd is asked again.
constexpr std::chrono::milliseconds kRefusedPause{250};

}  // namespace

Writer::Writer(const std::string& sensor, const slipd_frames& frames, const std::string& socket)
    : source_(sensor, frames, socket), thread_([this] { run(); }) {}

Writer::~Writer() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  come_.notify_all();
  thread_.join();
}

void Writer::put(Frame frame) {
  {
    const std::lock_guard lock(mutex_);
    if (waiting_.size() == kMostWaiting) {
      waiting_.pop_front();
      unsent_.fetch_add(1, std::memory_order_relaxed);
    }
    waiting_.push_back(std::move(frame));
  }
  come_.notify_one();
}

std::string Writer::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

bool Writer::take(Frame& out) {
  std::unique_lock lock(mutex_);
  come_.wait(lock, [&] { return ending_ || !waiting_.empty(); });
  if (ending_) return false;
  out = std::move(waiting_.front());
  waiting_.pop_front();
  return true;
}

void Writer::say(std::string trouble) {
  std::unique_lock lock(mutex_);
  trouble_ = std::move(trouble);
  if (!trouble_.empty()) come_.wait_for(lock, kRefusedPause, [&] { return ending_; });
}

void Writer::send(const Frame& frame) {
  try {
    source_.push(frame.values, frame.time_ns, frame.sequence, kSlipdPatienceS);
    sent_.fetch_add(1, std::memory_order_relaxed);
    say("");
  } catch (const client::Error& error) {
    unsent_.fetch_add(1, std::memory_order_relaxed);
    say(error.what());
  }
}

void Writer::run() {
  for (Frame frame; take(frame);) send(frame);
}

}  // namespace slipd::feed
