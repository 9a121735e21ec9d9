#include "daemon/pipeline/bias_worker.hpp"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "daemon/board/board.hpp"

namespace slipd {
namespace {

using namespace std::chrono_literals;

// A zero that follows drift is kept anew so often: a day of it is a few hundred writes.
constexpr std::int64_t kKeepIntervalNs = 300'000'000'000;
// And when its device goes away, if it has followed for so long: one that comes and goes writes no more than
// that.
constexpr std::int64_t kKeepAtLeastNs = 10'000'000'000;
constexpr auto kKeeperPatience = 1s;

BiasEstimator::Steps steps_of(const SensorInfo& sensor) {
  return {static_cast<float>(sensor.step_normal_pa), static_cast<float>(sensor.step_shear_pa)};
}

}  // namespace

BiasWorker::BiasWorker(SensorStatus& status, const SensorInfo& sensor, BiasIdentity identity, Doorbell& store)
    : status_(status),
      identity_(std::move(identity)),
      store_(store),
      bias_estimator_(sensor.layout, steps_of(sensor)),
      copy_(bias_estimator_.zero()) {
  bias_estimator_.skip_requests(status_.zero.newest().number);
  status_.zero.report.store(bias_estimator_.report());
}

void BiasWorker::restore(const Bias& zero) {
  bias_estimator_.restore(zero);
  offered_confirmed_ns_ = zero.confirmed_ns;
  status_.zero.report.store(bias_estimator_.report());
}

void BiasWorker::reopened() {
  bias_estimator_.reopened();
  tell();
}

void BiasWorker::apply(FrameSlot& frame) noexcept {
  const BiasRequest request = status_.zero.newest();
  if (request.number != bias_estimator_.report().asked) bias_estimator_.ask(request.number, request.force);
  bias_estimator_.apply(frame);
}

void BiasWorker::afterwards() noexcept {
  if (!bias_estimator_.judge()) return;
  if (worth_keeping(kKeepIntervalNs)) offer();
  tell();
}

void BiasWorker::tell() noexcept {
  const BiasReport& report = bias_estimator_.report();
  status_.zero.report.store(report);
  // The copy comes before the report, so that who sees a zero taken finds it.
  // Relaxed: only whether to ring.
  if (report.answered != status_.zero.settled() || filled_.load(std::memory_order_relaxed)) store_.ring();
}

bool BiasWorker::worth_keeping(std::int64_t followed_ns) const noexcept {
  const BiasReport& report = bias_estimator_.report();
  return report.taken != offered_takings_ || report.confirmed_ns - offered_confirmed_ns_ >= followed_ns;
}

void BiasWorker::offer() noexcept {
  // Acquire: pairs with the release in release(), so that the keeper has read all of the copy.
  if (filled_.load(std::memory_order_acquire)) return;
  const Bias& zero = bias_estimator_.zero();
  std::copy(zero.bias_pa.begin(), zero.bias_pa.end(), copy_.bias_pa.begin());
  std::copy(zero.noise_pa.begin(), zero.noise_pa.end(), copy_.noise_pa.begin());
  copy_.origin = zero.origin;
  copy_.taken_ns = zero.taken_ns;
  copy_.confirmed_ns = offered_confirmed_ns_ = zero.confirmed_ns;
  copy_takings_ = offered_takings_ = bias_estimator_.report().taken;
  filled_.store(true, std::memory_order_release);  // pairs with the acquire in to_keep()
}

void BiasWorker::rest() {
  if (!worth_keeping(kKeepAtLeastNs)) return;
  const auto until = std::chrono::steady_clock::now() + kKeeperPatience;
  while (filled_.load(std::memory_order_relaxed) &&
         std::chrono::steady_clock::now() < until)  // offer acquires
    std::this_thread::sleep_for(5ms);
  offer();
  store_.ring();
}

const Bias* BiasWorker::to_keep() const noexcept {
  return filled_.load(std::memory_order_acquire) ? &copy_ : nullptr;  // pairs with the release in offer
}

void BiasWorker::release() noexcept {
  kept_takings_ = copy_takings_;
  filled_.store(false, std::memory_order_release);  // pairs with the acquire in offer
}

}  // namespace slipd
