#include "daemon/record/recorder.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <asio/post.hpp>
#include <chrono>
#include <limits>
#include <new>
#include <thread>
#include <utility>

#include "core/recording/recording.hpp"
#include "core/storage/bounded_output.hpp"
#include "daemon/rt/clock.hpp"
#include "daemon/rt/thread.hpp"

namespace slipd {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr std::size_t kStackBytes = std::size_t{256} * 1024;
// Memory for frames that wait for their readers, bytes, for all recordings together. Smaller: a slow reader
// loses frames earlier. Larger: clients can make slipd larger.
constexpr std::size_t kQueueBytes = std::size_t{24} * 1024 * 1024;
// Frames of a queue. Fewer than the least are of no use; more than the most are not needed.
constexpr std::size_t kLeastQueueFrames = 16, kMostQueueFrames = 4096;
// Recordings that their readers left unread, beyond which none is started.
constexpr std::size_t kMostUnread = 16;
// Time between two looks at an empty queue.
constexpr auto kPollInterval = 5ms;
// Time that end_all leaves to all recordings together.
constexpr auto kEndPatience = 200ms;
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

std::size_t bytes_of_frame(std::size_t taxels) {
  return 3 * sizeof(float) * taxels;
}

bool is_hang_up(const std::error_code& error) {
  return error == std::errc::broken_pipe || error == std::errc::connection_reset;
}

std::string trouble_of(const std::error_code& error) {
  if (error == std::errc::timed_out)
    return "what reads the recording took nothing for too long, the rest is lost";
  if (is_hang_up(error)) return "what read the recording has closed its descriptor";
  return "sending the recording: " + error.message();
}

}  // namespace

// A recording and its thread. Its owner joins the thread before it reads the result.
struct Recorder::Job {
  Job(std::uint64_t its_number, SensorStatus& of, UniqueFd to, const RecordingHeader& header,
      std::size_t queue_frames, double for_seconds)
      : number(its_number),
        status(of),
        socket(std::move(to)),
        queue(header.layout.size(), queue_frames),
        queue_bytes(queue_frames * bytes_of_frame(header.layout.size())),
        patience{.until_ns = &until_ns},
        writer(socket.get(), header, kRecordingFlush, patience),
        seconds(for_seconds) {}

  bool to_stop() const noexcept { return until_ns.load(std::memory_order_relaxed) != kNever; }

  std::uint64_t number;
  SensorStatus& status;
  UniqueFd socket;
  FrameQueue queue;
  std::size_t queue_bytes;
  // When it must have ended. Set by io, read by the thread; no other memory is read because of it.
  std::atomic<std::int64_t> until_ns{kNever};
  OutputPatience patience;
  RecordingWriter writer;
  double seconds;
  std::shared_ptr<std::atomic<bool>> cancelled;
  std::function<void(std::uint64_t, const RecordingResult&)> done;  // used by io only
  RecordingResult result;                                           // written by the thread
  Thread thread;
};

Recorder::Recorder(asio::io_context& io) : io_(io) {}

Recorder::~Recorder() {
  end_all();
}

void Recorder::end_all() {
  const std::chrono::nanoseconds until = (Clock::now() + kEndPatience).time_since_epoch();
  for (const auto& each : running_) each->until_ns = until.count();
  while (!running_.empty()) {
    const std::unique_ptr<Job> job = std::move(running_.front());
    running_.pop_front();
    finish(*job);
  }
}

// Half of the memory that other recordings leave. 0: there is none.
std::size_t Recorder::queue_frames(std::size_t taxels) const {
  std::size_t used = 0;
  for (const auto& each : running_) used += each->queue_bytes;
  const std::size_t room = kQueueBytes - std::min(kQueueBytes, used);
  const std::size_t frames = room / 2 / bytes_of_frame(taxels);
  if (frames < kLeastQueueFrames && used > 0) return 0;
  return std::clamp(frames, kLeastQueueFrames, kMostQueueFrames);
}

std::uint64_t Recorder::start(SensorStatus& status, UniqueFd socket, double seconds,
                              std::shared_ptr<std::atomic<bool>> cancelled,
                              std::function<void(std::uint64_t, const RecordingResult&)> done) {
  const DeviceFacts facts = status.facts();
  if (!facts.layout) throw RecordingRefused("this sensor's device has not been opened yet");
  std::erase_if(unread_, [](const UniqueFd& each) { return unread_bytes(each.get()) == 0; });
  if (unread_.size() >= kMostUnread)
    throw RecordingRefused("the readers of " + std::to_string(unread_.size()) +
                           " recordings that have ended have not read them to the end; let them read, or end "
                           "them");
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
  auto made = std::make_unique<Job>(started_ + 1, status, std::move(socket), header, frames, seconds);
  Job& job = *made;
  job.cancelled = std::move(cancelled);
  job.done = std::move(done);
  unread_.reserve(unread_.size() + running_.size() + 1);  // so that finish has room for each
  running_.push_back(std::move(made));
  if (!status.record_tap.attach(job.queue)) {
    running_.pop_back();
    throw RecordingRefused(status.name + " is being recorded already; wait for that to end");
  }
  try {
    job.thread = Thread("rec:" + status.name, kStackBytes, [this, &job] { write(job); });
  } catch (...) {
    status.record_tap.detach();
    running_.pop_back();
    throw;
  }
  return ++started_;
}

// In the io thread, after the thread of a recording has done all it could.
void Recorder::ended(std::uint64_t number) {
  const auto found = std::find_if(running_.begin(), running_.end(),
                                  [number](const auto& each) { return each->number == number; });
  if (found == running_.end()) return;  // end_all was faster
  const std::unique_ptr<Job> job = std::move(*found);
  running_.erase(found);
  finish(*job);
}

void Recorder::finish(Job& job) {
  job.thread = {};  // joins it
  if (unread_bytes(job.socket.get()) > 0) {
    shutdown(job.socket.get(), SHUT_WR);  // its reader sees the end
    unread_.push_back(std::move(job.socket));
  } else {
    job.socket = {};
  }
  job.done(job.number, job.result);
}

// The body of the writer thread.
void Recorder::write(Job& job) {
  const auto begin = Clock::now();
  const auto end =
      begin + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(job.seconds));
  RecordingResult& result = job.result;
  std::error_code error;
  const auto take_all = [&] {
    while (const FrameSlot* frame = error ? nullptr : job.queue.front()) {
      error = job.writer.append(*frame);
      job.queue.pop();
      if (!error) ++result.frames;
    }
  };
  while (!error && Clock::now() < end && !job.to_stop() && !*job.cancelled) {
    take_all();
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
    if (!error) error = await_hang_up(job.socket.get(), std::clamp(left, 0ms, kPollInterval));
  }
  job.status.record_tap.detach();
  take_all();
  const std::error_code at_end = job.writer.finish();
  if (!error) error = at_end;
  if (!error) error = await_read(job.socket.get(), job.patience);
  if (job.to_stop()) {
    result.trouble = "slipd stops, or takes up another configuration";
    if (error) result.trouble += "; and " + trouble_of(error);
  } else if (error) {
    result.trouble = trouble_of(error);
    result.left = is_hang_up(error);
  }
  result.missed = job.queue.missed();
  result.bytes = job.writer.bytes();
  result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  // Retried, because without the post io would not know that it ended.
  while (!job.to_stop()) {
    try {
      asio::post(io_, [this, number = job.number] { ended(number); });
      return;
    } catch (const std::bad_alloc&) {
      std::this_thread::sleep_for(kPollInterval);
    }
  }
}

}  // namespace slipd
