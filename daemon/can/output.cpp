#include "daemon/can/output.hpp"

namespace slipd::can {
namespace {

constexpr std::size_t kStackBytes = std::size_t{128} * 1024;

std::size_t messages_of_a_period(const Settings& settings) {
  const std::size_t of_a_source = settings.can->sliding ? 3 : 2;
  return of_a_source * (settings.sensors.size() + settings.grasps.size()) + 1;
}

}  // namespace

Output::Output(const Settings& settings, Board& board, Doorbell& bell)
    : settings_(settings),
      bell_(bell),
      port_(*settings.can, messages_of_a_period(settings)),
      scheduler_(settings, board, port_, board.logs.emplace_back(), Doorbell::Clock::now()) {}

void Output::start(const RealtimeGrant& grant) {
  thread_ = Thread("can", kStackBytes, [this, grant] {
    enter_realtime(settings_.realtime, grant);
    run();
  });
}

bool Output::stop(std::chrono::steady_clock::time_point deadline) {
  stop_.store(true, std::memory_order_relaxed);
  bell_.ring();
  return thread_.join_until(deadline);
}

void Output::run() noexcept {
  for (;;) {
    const std::uint32_t rung = bell_.ring_count();
    if (stop_.load(std::memory_order_relaxed)) break;
    bell_.wait(rung, scheduler_.step(Doorbell::Clock::now()));
  }
  scheduler_.send_final(Doorbell::Clock::now());
}

}  // namespace slipd::can
