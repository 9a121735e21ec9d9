#include "daemon/record/recorder.hpp"

#include <fcntl.h>

#include <algorithm>
#include <asio/post.hpp>
#include <chrono>
#include <mutex>
#include <new>
#include <thread>

#include "core/storage/bounded_output.hpp"
#include "core/storage/recording.hpp"
#include "daemon/rt/clock.hpp"
#include "daemon/rt/thread.hpp"

namespace slipd {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr std::size_t kStackBytes = std::size_t{256} * 1024;
// Memory for frames that wait for the disk, bytes, for all recordings together. Smaller: a slow disk loses
// frames earlier. Larger: clients can make slipd larger.
constexpr std::size_t kQueueBytes = std::size_t{24} * 1024 * 1024;
// Frames of a queue. Fewer than the least are of no use; more than the most are not needed.
constexpr std::size_t kLeastQueueFrames = 16, kMostQueueFrames = 4096;
// Threads left behind beyond which no recording is started.
constexpr std::size_t kMostLeftBehind = 4;
// Time between two looks at an empty queue.
constexpr auto kPollInterval = 5ms;
// Longest time of end_all, for all recordings together.
constexpr auto kEndPatience = 300ms;

std::size_t bytes_of_frame(std::size_t taxels) {
  return 3 * sizeof(float) * taxels;
}

// Posts to io, and retries while there is no memory: without the post io would never know that it ended.
template <typename Handler>
void post_retrying(asio::io_context& io, Handler handler) {
  for (;;) {
    try {
      asio::post(io, handler);
      return;
    } catch (const std::bad_alloc&) {
      std::this_thread::sleep_for(kPollInterval);
    }
  }
}

void require_fit(int fd) {
  const int flags = fcntl(fd, F_GETFL);
  if (flags < 0 || (flags & O_ACCMODE) == O_RDONLY)
    throw UnfitFile("the descriptor passed along is not open for writing");
  if (kind_of_output(fd) == OutputKind::other)
    throw UnfitFile("the descriptor passed along is neither a regular file, a pipe nor a socket");
}

std::string trouble_of(const std::error_code& error) {
  if (error == std::errc::timed_out)
    return "writing the recording: what reads it took nothing for too long, the rest is lost";
  return "writing the recording: " + error.message();
}

}  // namespace

// Owned by its thread and by Recorder, so that a thread that is left behind keeps what it uses.
struct Recorder::Job {
  Job(SensorStatus& of, UniqueFd to, const RecordingHeader& header, std::size_t queue_frames,
      double for_seconds)
      : file(std::move(to)),
        queue(header.layout.size(), queue_frames),
        queue_bytes(queue_frames * bytes_of_frame(header.layout.size())),
        writer(file.get(), header, kRecordingFlush, {.hurry = &stop}),
        seconds(for_seconds),
        status(&of) {}

  // Ends the use of the status. Called by its thread, or by io if that does not come to it.
  void release_status() {
    const std::lock_guard lock(status_mutex);
    if (status != nullptr) status->record_tap.detach();
    status = nullptr;
  }

  UniqueFd file;
  FrameQueue queue;
  std::size_t queue_bytes;
  std::atomic<bool> stop{false};  // set by io, read by the thread; no other memory is read because of it
  RecordingWriter writer;
  double seconds;
  std::shared_ptr<std::atomic<bool>> cancelled;
  std::function<void(const RecordingResult&)> done;  // used by io only

  std::mutex status_mutex;
  SensorStatus* status;  // null: released
};

struct Recorder::Running {
  std::shared_ptr<Job> job;
  Thread thread;
};

Recorder::Recorder(asio::io_context& io) : io_(io) {}

Recorder::~Recorder() {
  end_all();
}

bool Recorder::end_all() {
  const auto deadline = Clock::now() + kEndPatience;
  for (Running& each : running_) each.job->stop = true;
  for (Running& each : running_) {
    if (each.thread.join_until(deadline)) continue;
    each.job->release_status();
    left_behind_.push_back(each.job);
    if (const auto done = std::exchange(each.job->done, nullptr))
      done({.trouble = "slipd stops, or takes up another configuration, and what reads the recording takes "
                       "nothing"});
  }
  std::erase_if(running_, [this](const Running& each) {
    return std::find(left_behind_.begin(), left_behind_.end(), each.job) != left_behind_.end();
  });
  return left_behind_.empty();
}

// Half of the memory that other recordings leave. 0: there is none.
std::size_t Recorder::queue_frames(std::size_t taxels) const {
  std::size_t used = 0;
  for (const Running& each : running_) used += each.job->queue_bytes;
  for (const auto& each : left_behind_) used += each->queue_bytes;
  const std::size_t room = kQueueBytes - std::min(kQueueBytes, used);
  const std::size_t frames = room / 2 / bytes_of_frame(taxels);
  if (frames < kLeastQueueFrames && used > 0) return 0;
  return std::clamp(frames, kLeastQueueFrames, kMostQueueFrames);
}

void Recorder::start(SensorStatus& status, UniqueFd file, double seconds,
                     std::shared_ptr<std::atomic<bool>> cancelled,
                     std::function<void(const RecordingResult&)> done) {
  require_fit(file.get());
  const DeviceFacts facts = status.facts();
  if (!facts.layout) throw RecordingRefused("this sensor's device has not been opened yet");
  if (left_behind_.size() >= kMostLeftBehind)
    throw RecordingRefused("earlier recordings still wait for readers that take nothing; end these readers");
  const std::size_t frames = queue_frames(facts.layout->size());
  if (frames == 0)
    throw RecordingRefused("other recordings take all memory that there is for them; wait for one to end");
  const Now now = Now::read();
  const RecordingHeader header{.sensor = status.name,
                               .sensor_class = facts.sensor_class,
                               .layout = *facts.layout,
                               .rate_hz = facts.rate_hz,
                               .simulated = status.simulated.load(std::memory_order_relaxed),
                               .start_realtime_ns = now.realtime_ns,
                               .start_monotonic_ns = now.monotonic_ns,
                               .description = facts.description,
                               .zeroed = status.bias.known()};
  const auto job = std::make_shared<Job>(status, std::move(file), header, frames, seconds);
  job->cancelled = std::move(cancelled);
  job->done = std::move(done);
  running_.push_back({job, {}});
  if (!status.record_tap.attach(job->queue)) {
    running_.pop_back();
    throw RecordingRefused(status.name + " is being recorded already; wait for that to end");
  }
  try {
    running_.back().thread = Thread("rec:" + status.name, kStackBytes, [this, job] {
      const RecordingResult result = write(*job);
      post_retrying(io_, [this, which = job.get(), result] { ended(which, result); });
    });
  } catch (...) {
    job->release_status();
    running_.pop_back();
    throw;
  }
}

// In the io thread, after the thread of a recording has written all it could.
void Recorder::ended(const Job* job, const RecordingResult& result) {
  std::erase_if(left_behind_, [&](const auto& each) { return each.get() == job; });
  const auto found = std::find_if(running_.begin(), running_.end(),
                                  [&](const Running& each) { return each.job.get() == job; });
  if (found == running_.end()) return;
  const auto done = std::move(found->job->done);
  running_.erase(found);
  if (done) done(result);
}

// The body of the writer thread.
RecordingResult Recorder::write(Job& job) {
  const auto begin = Clock::now();
  const auto end =
      begin + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(job.seconds));
  RecordingResult result;
  std::error_code error;
  const auto take_all = [&] {
    while (const FrameSlot* frame = error ? nullptr : job.queue.front()) {
      error = job.writer.append(*frame);
      job.queue.pop();
      if (!error) ++result.frames;
    }
  };
  while (!error && Clock::now() < end && !job.stop && !*job.cancelled) {
    take_all();
    std::this_thread::sleep_until(std::min(end, Clock::now() + kPollInterval));
  }
  job.release_status();
  take_all();
  if (!error) error = job.writer.finish();
  if (error) {
    result.trouble = trouble_of(error);
  } else if (job.stop) {
    result.trouble = "slipd stops, or takes up another configuration";
  }
  result.missed = job.queue.missed();
  result.bytes = job.writer.bytes();
  result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return result;
}

}  // namespace slipd
