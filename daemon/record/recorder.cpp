#include "daemon/record/recorder.hpp"

#include <fcntl.h>

#include <algorithm>
#include <asio/post.hpp>
#include <chrono>
#include <new>
#include <thread>

#include "core/storage/recording.hpp"
#include "daemon/rt/clock.hpp"
#include "daemon/rt/thread.hpp"

namespace slipd {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr std::size_t kStackBytes = std::size_t{256} * 1024;
// Largest queue of frames that wait for the disk, bytes. Smaller: a slow disk loses frames earlier.
constexpr std::size_t kQueueBytes = std::size_t{32} * 1024 * 1024;
// Time between two looks at an empty queue.
constexpr auto kPollInterval = 5ms;

std::size_t queue_frames(std::size_t taxels) {
  return std::clamp<std::size_t>(kQueueBytes / (3 * sizeof(float) * taxels), 16, 4096);
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

}  // namespace

struct Recorder::Job {
  Job(SensorStatus& its_status, UniqueFd to, const RecordingHeader& header, double for_seconds)
      : status(its_status),
        file(std::move(to)),
        queue(header.layout.size(), queue_frames(header.layout.size())),
        writer(file.get(), header),
        seconds(for_seconds) {}

  SensorStatus& status;
  UniqueFd file;
  FrameQueue queue;
  RecordingWriter writer;
  double seconds;
  std::shared_ptr<std::atomic<bool>> cancelled;
  const std::atomic<bool>* stop = nullptr;
  Thread thread;
};

Recorder::Recorder(asio::io_context& io) : io_(io) {}

Recorder::~Recorder() {
  stop_ = true;
}

void Recorder::end_all() {
  stop_ = true;
  for (const auto& job : jobs_) job->thread = Thread();  // joins
  stop_ = false;
}

void Recorder::start(SensorStatus& status, UniqueFd file, double seconds,
                     std::shared_ptr<std::atomic<bool>> cancelled,
                     std::function<void(const RecordingResult&)> done) {
  const int flags = fcntl(file.get(), F_GETFL);
  if (flags < 0 || (flags & O_ACCMODE) == O_RDONLY) {
    throw UnfitFile("the descriptor passed along is not open for writing");
  }
  const DeviceFacts facts = status.facts();
  if (!facts.layout) throw RecordingRefused("this sensor's device has not been opened yet");
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
  auto job = std::make_unique<Job>(status, std::move(file), header, seconds);
  job->cancelled = std::move(cancelled);
  job->stop = &stop_;
  Job* const started = job.get();
  jobs_.push_back(std::move(job));
  if (!status.record_tap.attach(started->queue)) {
    jobs_.pop_back();
    throw RecordingRefused(status.name + " is being recorded already; wait for that to end");
  }
  const auto forget = [this, started] {
    std::erase_if(jobs_, [&](const auto& each) { return each.get() == started; });
  };
  try {
    started->thread =
        Thread("rec:" + status.name, kStackBytes, [this, started, forget, done = std::move(done)] {
          const RecordingResult result = write(*started);
          post_retrying(io_, [forget, done, result] {
            forget();
            done(result);
          });
        });
  } catch (...) {
    status.record_tap.detach();
    forget();
    throw;
  }
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
  while (!error && Clock::now() < end && !*job.stop && !*job.cancelled) {
    take_all();
    std::this_thread::sleep_until(std::min(end, Clock::now() + kPollInterval));
  }
  job.status.record_tap.detach();
  take_all();
  if (!error) error = job.writer.flush();
  if (error) {
    result.trouble = "writing the recording: " + error.message();
  } else if (*job.stop) {
    result.trouble = "slipd stops, or takes up another configuration";
  }
  result.missed = job.queue.missed();
  result.bytes = job.writer.bytes();
  result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return result;
}

}  // namespace slipd
