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

Zeroing::Steps steps_of(const SensorInfo& sensor) {
  return {static_cast<float>(sensor.step_normal_pa), static_cast<float>(sensor.step_shear_pa)};
}

}  // namespace

ZeroDesk::ZeroDesk(Panel& panel, const SensorInfo& sensor, ZeroIdentity identity, Doorbell& keeper)
    : panel_(panel),
      identity_(std::move(identity)),
      keeper_(keeper),
      zeroing_(sensor.layout, steps_of(sensor)),
      copy_(zeroing_.zero()) {
  zeroing_.skip_requests(panel_.zero.newest().number);
  panel_.zero.report.store(zeroing_.report());
}

void ZeroDesk::restore(const Zero& zero) {
  zeroing_.restore(zero);
  offered_confirmed_ns_ = zero.confirmed_ns;
  panel_.zero.report.store(zeroing_.report());
}

void ZeroDesk::reopened() {
  zeroing_.reopened();
  tell();
}

void ZeroDesk::apply(FrameSlot& frame) noexcept {
  const ZeroRequest request = panel_.zero.newest();
  if (request.number != zeroing_.report().asked) zeroing_.ask(request.number, request.force);
  zeroing_.apply(frame);
}

void ZeroDesk::afterwards() noexcept {
  if (!zeroing_.judge()) return;
  if (worth_keeping(kKeepIntervalNs)) offer();
  tell();
}

void ZeroDesk::tell() noexcept {
  const ZeroReport& report = zeroing_.report();
  panel_.zero.report.store(report);
  // The copy comes before the report, so that who sees a zero taken finds it.
  // Relaxed: only whether to ring.
  if (report.answered != panel_.zero.settled() || filled_.load(std::memory_order_relaxed)) keeper_.ring();
}

bool ZeroDesk::worth_keeping(std::int64_t followed_ns) const noexcept {
  const ZeroReport& report = zeroing_.report();
  return report.taken != offered_takings_ || report.confirmed_ns - offered_confirmed_ns_ >= followed_ns;
}

void ZeroDesk::offer() noexcept {
  // Acquire: pairs with the release in release(), so that the keeper has read all of the copy.
  if (filled_.load(std::memory_order_acquire)) return;
  const Zero& zero = zeroing_.zero();
  std::copy(zero.bias_pa.begin(), zero.bias_pa.end(), copy_.bias_pa.begin());
  std::copy(zero.noise_pa.begin(), zero.noise_pa.end(), copy_.noise_pa.begin());
  copy_.origin = zero.origin;
  copy_.taken_ns = zero.taken_ns;
  copy_.confirmed_ns = offered_confirmed_ns_ = zero.confirmed_ns;
  copy_takings_ = offered_takings_ = zeroing_.report().taken;
  filled_.store(true, std::memory_order_release);  // pairs with the acquire in to_keep()
}

void ZeroDesk::rest() {
  if (!worth_keeping(kKeepAtLeastNs)) return;
  const auto until = std::chrono::steady_clock::now() + kKeeperPatience;
  while (filled_.load(std::memory_order_relaxed) &&
         std::chrono::steady_clock::now() < until)  // offer acquires
    std::this_thread::sleep_for(5ms);
  offer();
  keeper_.ring();
}

const Zero* ZeroDesk::to_keep() const noexcept {
  return filled_.load(std::memory_order_acquire) ? &copy_ : nullptr;  // pairs with the release in offer
}

void ZeroDesk::release() noexcept {
  kept_takings_ = copy_takings_;
  filled_.store(false, std::memory_order_release);  // pairs with the acquire in offer
}

}  // namespace slipd
