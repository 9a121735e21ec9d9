#include "daemon/can/subject.hpp"

#include <algorithm>

#include "core/estimate/grasp.hpp"

namespace slipd::can {
namespace {

// States that the estimate thread says once and means until it says otherwise.
bool lasting(State state) noexcept {
  return state == State::learning || state == State::stale || state == State::fault;
}

}  // namespace

Subject::Subject(const Settings& settings, const Board& board, std::vector<std::size_t> sensors,
                 bool is_grasp)
    : settings_(settings),
      board_(board),
      sensors_(std::move(sensors)),
      is_grasp_(is_grasp),
      members_(sensors_.size()),
      alert_(settings.alerts) {}

Subject::View Subject::look(std::int64_t now_ns) noexcept {
  View view;
  for (const std::size_t sensor : sensors_) {
    // The link first: once it is open, the acquire thread has said whether it is simulated.
    const Link link = board_.sensors[sensor]->link.load(std::memory_order_acquire);
    view.opening = view.opening || link == Link::opening;
    view.simulated = view.simulated || board_.sensors[sensor]->simulated.load(std::memory_order_relaxed);
  }
  view.estimate = is_grasp_ ? together(now_ns) : sensor_now(sensors_.front(), now_ns);
  return view;
}

Estimate Subject::sensor_now(std::size_t sensor, std::int64_t now_ns) const noexcept {
  Estimate estimate = board_.sensors[sensor]->latest.load().estimate;
  const std::chrono::nanoseconds stale_after = settings_.sensors[sensor].stale_after;
  if (lasting(estimate.state) || now_ns - estimate.published_ns <= stale_after.count()) return estimate;
  Estimate stale;
  stale.sequence = estimate.sequence;
  stale.time_ns = estimate.time_ns;
  stale.published_ns = estimate.published_ns;
  return stale;
}

Estimate Subject::together(std::int64_t now_ns) noexcept {
  Estimate now;
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    members_[i] = sensor_now(sensors_[i], now_ns);
    now.sequence += members_[i].sequence;  // moves with each frame of any of them
    now.published_ns = std::max(now.published_ns, members_[i].published_ns);
  }
  const GraspMargin margin = grasp_margin(members_, settings_.alerts);
  now.state = margin.state;
  now.gamma = margin.gamma;
  now.friction = margin.friction;
  now.grip_increase_n = margin.grip_increase_n;
  if (now.sequence == last_.sequence && now.state == last_.state) return last_;
  now.alert = alert_.update(now.published_ns, now.gamma, 0);
  now.time_to_slip_s = forecast_.update(now.published_ns, now.gamma, 0);
  last_ = now;
  return now;
}

std::vector<Subject> make_subjects(const Settings& settings, const Board& board) {
  std::vector<Subject> subjects;
  for (std::size_t i = 0; i < settings.sensors.size(); ++i)
    subjects.emplace_back(settings, board, std::vector{i}, false);
  for (const GraspSettings& grasp : settings.grasps) {
    std::vector<std::size_t> sensors;
    for (std::size_t i = 0; i < settings.sensors.size(); ++i) {
      const auto& names = grasp.sensors;
      if (std::find(names.begin(), names.end(), settings.sensors[i].setup.name) != names.end())
        sensors.push_back(i);
    }
    subjects.emplace_back(settings, board, std::move(sensors), true);
  }
  return subjects;
}

}  // namespace slipd::can
