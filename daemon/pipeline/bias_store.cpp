#include "daemon/pipeline/bias_store.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <new>
#include <string>
#include <utility>

namespace slipd {
namespace {

using namespace std::chrono_literals;
constexpr std::size_t kStoreStackBytes = std::size_t{256} * 1024;
// The store sleeps until it is woken; a finite time, because the futex takes no infinite one.
constexpr auto kLongestStoreSleep = 1h;

double seconds_since(std::int64_t time_ns) {
  return 1e-9 * static_cast<double>(Now::read().monotonic_ns - time_ns);
}

// Why a zero is not used, and what to do; empty: it is used. Fits into a line of the log.
std::string doubt_text(const BiasReport& report, const std::string& sensor) {
  char off[32];
  std::snprintf(off, sizeof off, "%.0f Pa", static_cast<double>(report.off_pa));
  const std::string remedy = "; unload it, then run slipctl rebias " + sensor;
  switch (report.doubt) {
    case BiasDoubt::none:
      break;
    case BiasDoubt::elsewhere:
      return std::string("its pressure is ") + off +
             " off its zero: another sensor, drift, or a load on all of it" + remedy;
    case BiasDoubt::below:
      return std::string("its pressure is ") + off +
             ", far below its zero, which no contact can cause: another sensor's zero, or one taken under "
             "load" +
             remedy;
  }
  return {};
}

}  // namespace

BiasStore::~BiasStore() {
  request_stop();
}

std::shared_ptr<BiasWorker> BiasStore::register_sensor(SensorStatus& status, const SensorInfo& sensor,
                                                       const BiasIdentity& identity, LogRing& log) {
  auto worker = std::make_shared<BiasWorker>(status, sensor, identity, bell_);
  std::string trouble;
  try {
    if (const auto zero = load_bias(bias_file_path(identity), identity)) {
      worker->restore(*zero);
      log.write(LogLevel::info, {status.name}, "%s: its zero, taken %.0f s ago, is restored",
                status.name.c_str(), seconds_since(zero->taken_ns));
    } else {
      // save() ends it: the first zero is saved at once.
      trouble = "its zero is not known yet: unload it, then run slipctl rebias " + status.name;
      log.write(LogLevel::warning, {status.name}, "%s: %s", status.name.c_str(), trouble.c_str());
    }
  } catch (const std::exception& error) {
    trouble = error.what();
    log.write(LogLevel::error, {status.name, Cause::machine}, "%s: its zero cannot be restored: %s",
              status.name.c_str(), trouble.c_str());
  }
  status.change_facts([&](DeviceFacts& facts) { facts.zero_trouble = trouble; });
  const std::lock_guard lock(mutex_);
  workers_.push_back(worker);
  if (!running_ && !stop_.load(std::memory_order_relaxed)) {
    thread_ = Thread("zeros", kStoreStackBytes, [this] { run(); });
    running_ = true;
  }
  bell_.ring();  // for requests that the previous device left
  return worker;
}

void BiasStore::unregister_sensor(const std::shared_ptr<BiasWorker>& worker) {
  const std::lock_guard lock(mutex_);
  std::erase(workers_, worker);
}

void BiasStore::request_stop() {
  {
    const std::lock_guard lock(mutex_);  // no thread is started afterwards
    stop_.store(true, std::memory_order_relaxed);
  }
  bell_.ring();
}

std::vector<std::shared_ptr<BiasWorker>> BiasStore::workers() const {
  const std::lock_guard lock(mutex_);
  return workers_;
}

void BiasStore::run() {
  for (bool last = false; !last;) {
    const std::uint32_t rung = bell_.ring_count();
    last = stop_.load(std::memory_order_relaxed);
    try {
      for (const auto& worker : workers()) process(*worker);
    } catch (const std::bad_alloc&) {  // the next round tries again
    }
    if (!last) bell_.wait(rung, Doorbell::Clock::now() + kLongestStoreSleep);
  }
}

void BiasStore::process(BiasWorker& worker) {
  BiasChannel& channel = worker.status().bias;
  // The report before the copy: a bias that the report contains was handed over before.
  const BiasReport report = channel.report.load();
  report_doubt(worker, report);
  if (const Bias* zero = worker.pending_save()) {
    save(worker, *zero, report);
    worker.save_done();
  }
  if (report.answered == channel.completed()) return;
  // The copy held an older bias. The worker hands the new one over with the next block of frames.
  if (report.answer == BiasResult::taken && worker.saved_taken() != report.taken) return;
  channel.complete(report.answered);
  io_wakeup_.notify();
}

// Once at its beginning and once at its end.
void BiasStore::report_doubt(BiasWorker& worker, const BiasReport& report) {
  if (std::exchange(worker.logged_doubt(), report.doubt) == report.doubt) return;
  const std::string& name = worker.status().name;
  const std::string trouble = doubt_text(report, name);
  if (trouble.empty()) {
    log_.write(LogLevel::info, {name}, "%s: it agrees with its zero again, or has a new one", name.c_str());
  } else {
    log_.write(LogLevel::warning, {name, Cause::device}, "%s: its zero is not used: %s", name.c_str(),
               trouble.c_str());
  }
  worker.status().change_facts([&](DeviceFacts& facts) { facts.zero_trouble = trouble; });
}

void BiasStore::save(BiasWorker& worker, const Bias& zero, const BiasReport& report) {
  const std::string& name = worker.status().name;
  std::string trouble = doubt_text(report, name);
  try {
    const auto file = bias_file_path(worker.identity());
    save_bias(file, worker.identity(), zero);
    log_.write(LogLevel::info, {name}, "%s: its zero (%s) is kept in %s", name.c_str(),
               std::string(to_string(zero.origin)).c_str(), file.c_str());
  } catch (const std::exception& error) {
    trouble = error.what();
    log_.write(LogLevel::error, {name, Cause::machine},
               "%s: its zero cannot be kept, and is lost with the next start: %s", name.c_str(),
               trouble.c_str());
  }
  worker.status().change_facts([&](DeviceFacts& facts) { facts.zero_trouble = trouble; });
}

}  // namespace slipd
