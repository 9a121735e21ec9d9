#include "daemon/pipeline/bias_worker.hpp"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "daemon/board/board.hpp"

namespace slipd {
namespace {

using namespace std::chrono_literals;

// A bias that follows drift is saved at this interval: a few hundred writes a day.
constexpr std::int64_t kSaveIntervalNs = 300'000'000'000;
// When the device is closed, a bias that was followed for this long is saved. Limits the writes of a device
// that is lost again and again.
constexpr std::int64_t kMinSaveIntervalNs = 10'000'000'000;
// How long closing a device waits for the store to take the previous bias. Longer delays a stop.
constexpr auto kStoreTimeout = 1s;

BiasEstimator::Steps steps_of(const SensorInfo& sensor) {
  return {static_cast<float>(sensor.step_normal_pa), static_cast<float>(sensor.step_shear_pa)};
}

}  // namespace

BiasWorker::BiasWorker(SensorStatus& status, const SensorInfo& sensor, BiasIdentity identity, Doorbell& store)
    : status_(status),
      identity_(std::move(identity)),
      store_(store),
      bias_estimator_(sensor.layout, steps_of(sensor), {}, identity_.exchangeable()),
      copy_(bias_estimator_.zero()) {
  bias_estimator_.skip_requests(status_.bias.newest_request().number);
  status_.bias.report.store(bias_estimator_.report());
}

void BiasWorker::restore(const Bias& zero) {
  bias_estimator_.restore(zero);
  handed_confirmed_ns_ = zero.confirmed_ns;
  status_.bias.report.store(bias_estimator_.report());
}

void BiasWorker::device_reopened() {
  bias_estimator_.reopened();
  publish_report();
}

void BiasWorker::apply(FrameSlot& frame) noexcept {
  const BiasRequest request = status_.bias.newest_request();
  if (request.number != bias_estimator_.report().asked) bias_estimator_.ask(request.number, request.force);
  bias_estimator_.apply(frame);
}

void BiasWorker::after_publish() noexcept {
  if (!bias_estimator_.judge()) return;
  if (should_save(kSaveIntervalNs)) hand_to_store();
  publish_report();
}

void BiasWorker::publish_report() noexcept {
  const BiasReport& report = bias_estimator_.report();
  status_.bias.report.store(report);
  const bool doubt_changed = std::exchange(published_doubt_, report.doubt) != report.doubt;
  // The copy is handed over before the report is published, so that the store finds both.
  // Relaxed: decides only whether to ring.
  if (doubt_changed || report.answered != status_.bias.completed() || filled_.load(std::memory_order_relaxed))
    store_.ring();
}

bool BiasWorker::should_save(std::int64_t followed_ns) const noexcept {
  const BiasReport& report = bias_estimator_.report();
  return report.taken != handed_taken_ || report.confirmed_ns - handed_confirmed_ns_ >= followed_ns;
}

void BiasWorker::hand_to_store(std::vector<float> last_pa) noexcept {
  // Acquire: pairs with the release in save_done(), so that the store has ended reading the copy.
  if (filled_.load(std::memory_order_acquire)) return;
  const Bias& zero = bias_estimator_.zero();
  std::copy(zero.bias_pa.begin(), zero.bias_pa.end(), copy_.bias_pa.begin());
  std::copy(zero.noise_pa.begin(), zero.noise_pa.end(), copy_.noise_pa.begin());
  copy_.origin = zero.origin;
  copy_.last_pa = std::move(last_pa);
  copy_.taken_ns = zero.taken_ns;
  copy_.confirmed_ns = handed_confirmed_ns_ = zero.confirmed_ns;
  copy_taken_ = handed_taken_ = bias_estimator_.report().taken;
  filled_.store(true, std::memory_order_release);  // pairs with the acquire in pending_save()
}

void BiasWorker::flush_to_store(bool last) {
  std::vector<float> reading;
  if (last) reading = bias_estimator_.last_reading();
  if (reading.empty() && !should_save(kMinSaveIntervalNs)) return;
  const auto until = std::chrono::steady_clock::now() + kStoreTimeout;
  while (filled_.load(std::memory_order_relaxed) &&
         std::chrono::steady_clock::now() < until)  // relaxed: hand_to_store acquires
    std::this_thread::sleep_for(5ms);
  hand_to_store(std::move(reading));
  store_.ring();
}

const Bias* BiasWorker::pending_save() const noexcept {
  return filled_.load(std::memory_order_acquire) ? &copy_
                                                 : nullptr;  // pairs with the release in hand_to_store
}

void BiasWorker::save_done() noexcept {
  saved_taken_ = copy_taken_;
  filled_.store(false, std::memory_order_release);  // pairs with the acquire in hand_to_store
}

}  // namespace slipd
