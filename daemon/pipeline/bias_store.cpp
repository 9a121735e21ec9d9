#include "daemon/pipeline/bias_store.hpp"

#include <algorithm>
#include <chrono>
#include <new>

namespace slipd {
namespace {

using namespace std::chrono_literals;
constexpr std::size_t kStackBytes = std::size_t{256} * 1024;
constexpr auto kLongestSleep = 1h;

double seconds_since(std::int64_t time_ns) {
  return 1e-9 * static_cast<double>(Now::read().monotonic_ns - time_ns);
}

}  // namespace

ZeroKeeper::~ZeroKeeper() {
  ask_to_stop();
}

std::shared_ptr<ZeroDesk> ZeroKeeper::attend(Panel& panel, const SensorInfo& sensor,
                                             const ZeroIdentity& identity, LogRing& log) {
  auto desk = std::make_shared<ZeroDesk>(panel, sensor, identity, bell_);
  std::string trouble;
  try {
    if (const auto zero = load_zero(zero_file(identity), identity)) {
      desk->restore(*zero);
      log.write(LogLevel::info, {panel.name}, "%s: its zero, taken %.0f s ago, is restored",
                panel.name.c_str(), seconds_since(zero->taken_ns));
    } else {
      log.write(LogLevel::warning, {panel.name},
                "%s: what it reads without load is not known yet: let go of it and say slipctl rebias %s",
                panel.name.c_str(), panel.name.c_str());
    }
  } catch (const std::exception& error) {
    trouble = error.what();
    log.write(LogLevel::error, {panel.name, Cause::machine}, "%s: its zero cannot be restored: %s",
              panel.name.c_str(), trouble.c_str());
  }
  panel.change_facts([&](DeviceFacts& facts) { facts.zero_trouble = trouble; });
  const std::lock_guard lock(mutex_);
  desks_.push_back(desk);
  if (!running_ && !stop_.load(std::memory_order_relaxed)) {
    thread_ = Thread("zeros", kStackBytes, [this] { run(); });
    running_ = true;
  }
  bell_.ring();  // for requests that were the last device's
  return desk;
}

void ZeroKeeper::leave(const std::shared_ptr<ZeroDesk>& desk) {
  const std::lock_guard lock(mutex_);
  std::erase(desks_, desk);
}

void ZeroKeeper::ask_to_stop() {
  {
    const std::lock_guard lock(mutex_);  // after it, no thread is started any more
    stop_.store(true, std::memory_order_relaxed);
  }
  bell_.ring();
}

std::vector<std::shared_ptr<ZeroDesk>> ZeroKeeper::desks() const {
  const std::lock_guard lock(mutex_);
  return desks_;
}

void ZeroKeeper::run() {
  for (bool last = false; !last;) {
    const std::uint32_t rung = bell_.rung();
    last = stop_.load(std::memory_order_relaxed);
    try {
      for (const auto& desk : desks()) look_at(*desk);
    } catch (const std::bad_alloc&) {  // with the next zero, then
    }
    if (!last) bell_.wait(rung, Doorbell::Clock::now() + kLongestSleep);
  }
}

void ZeroKeeper::look_at(ZeroDesk& desk) {
  ZeroPanel& told = desk.panel().zero;
  // First the report, then the copy: a zero that the report tells of has been put there before.
  const ZeroReport report = told.report.load();
  if (const Zero* zero = desk.to_keep()) {
    keep(desk, *zero);
    desk.release();
  }
  if (report.answered == told.settled()) return;
  // A copy that was still the last one's is filled anew with the next block.
  if (report.answer == ZeroAnswer::taken && desk.kept_takings() != report.taken) return;
  told.settle(report.answered);
  io_.ring();
}

void ZeroKeeper::keep(ZeroDesk& desk, const Zero& zero) {
  const std::string& name = desk.panel().name;
  std::string trouble;
  try {
    const auto file = zero_file(desk.identity());
    save_zero(file, desk.identity(), zero);
    log_.write(LogLevel::info, {name}, "%s: its zero (%s) is kept in %s", name.c_str(),
               std::string(to_string(zero.origin)).c_str(), file.c_str());
  } catch (const std::exception& error) {
    trouble = error.what();
    log_.write(LogLevel::error, {name, Cause::machine},
               "%s: its zero cannot be kept, and is lost with the next start: %s", name.c_str(),
               trouble.c_str());
  }
  desk.panel().change_facts([&](DeviceFacts& facts) { facts.zero_trouble = trouble; });
}

}  // namespace slipd
