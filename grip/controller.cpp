#include "grip/controller.hpp"

#include <algorithm>
#include <cstdio>

#include "bridges/support/clock.hpp"
#include "bridges/support/log.hpp"

namespace slipd::grip {
namespace {

using bridges::log;
using bridges::LogLevel;
using Clock = std::chrono::steady_clock;

// A wish of a person waits no longer, s.
constexpr double kLongestWaitS = 0.02;
constexpr double kAttachTimeoutS = 0.2;
// Between attempts to attach, which doubles: each is work for slipd.
constexpr std::chrono::milliseconds kFirstPause{50}, kLongestPause{2000};

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

}  // namespace

Controller::Controller(const Settings& settings)
    : settings_(settings),
      slipd_(settings.socket),
      law_(settings.law),
      gripper_(settings.dry_run ? make_dry_gripper() : make_gripper(settings.gripper, settings.law.most_n)),
      watch_(settings.law.fingers),
      thread_([this] { run(); }) {}

Controller::~Controller() {
  ended_.store(true, std::memory_order_relaxed);
  thread_.join();
}

nlohmann::json Controller::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void Controller::run() {
  while (!ended_.load(std::memory_order_relaxed)) step();
}

void Controller::step() {
  const slipd_estimate now = wait_for_estimate();
  const Reading reading = reading_of(now, finger_slides());
  const State before = law_.state();
  const double force_before_n = law_.force_n();
  // A sample's own time, so that forces follow the samples' clock on a machine that is late as well.
  const bool sampled = now.time_ns > 0 && reading.contact;
  const std::int64_t now_ns = sampled ? now.time_ns : bridges::monotonic_ns();
  const Wish wish = wish_.exchange(Wish::none, std::memory_order_relaxed);
  const GripperThread::Condition gripper = gripper_.condition();
  const Order order = law_.step(reading, wish, gripper.answers, now_ns);
  gripper_.command({.order = order, .speed_mm_s = settings_.speed_mm_s, .sequence = now.sequence});
  tell(now, before, force_before_n);
  nlohmann::json status{{"state", to_string(law_.state())},
                        {"why", to_string(law_.last_event())},
                        {"slipd", slipd_trouble_.empty() ? slipd_state_name(now.state) : slipd_trouble_},
                        {"force_n", order.force_n},
                        {"gripper", gripper.answers ? "answers" : gripper.trouble}};
  status["margin"] = law_.margin() ? nlohmann::json(*law_.margin()) : nlohmann::json();
  const std::string& trouble = watch_.judge(gripper.facts, reading, is_gripping(law_.state()), now_ns);
  tell_trouble(trouble);
  if (!trouble.empty()) status["trouble"] = trouble;
  if (gripper.facts.width_mm) status["width_mm"] = *gripper.facts.width_mm;
  if (gripper.facts.force_n) status["gripper_force_n"] = *gripper.facts.force_n;
  if (watch_.width_change_mm()) status["width_change_mm"] = *watch_.width_change_mm();
  const std::lock_guard lock(mutex_);
  status_ = std::move(status);
}

// Names that slipd does not have are told as well: nobody would see such a finger's slide.
void Controller::attach() {
  const auto now = Clock::now();
  if (now < attach_at_) return;
  std::string trouble;
  try {
    slipd_.attach(settings_.name, kAttachTimeoutS);
    for (const std::string& name : settings_.fingers) {
      slipd_estimate one{};
      if (slipd_latest(slipd_.get(), name.c_str(), settings_.law.max_age_s, &one) == SLIPD_INVALID)
        trouble = "the slipd at " + settings_.socket + " has no sensor \"" + name +
                  "\"; name its sensors in \"fingers\"";
    }
  } catch (const client::Error& error) {
    trouble = error.what();
  }
  attached_ = trouble.empty();
  if (attached_)
    log(LogLevel::notice, "reads \"" + settings_.name + "\" of the slipd at " + settings_.socket);
  else if (trouble != slipd_trouble_)
    log(LogLevel::warning, trouble);
  slipd_trouble_ = trouble;
  attach_pause_ = attached_ ? kFirstPause : std::clamp(2 * attach_pause_, kFirstPause, kLongestPause);
  attach_at_ = now + attach_pause_;
}

// The next estimate, or what the last one is worth now.
slipd_estimate Controller::wait_for_estimate() {
  if (!attached_) attach();
  slipd_estimate now{};
  if (!attached_) {
    slipd_latest(slipd_.get(), nullptr, 0, &now);  // nothing is known
    std::this_thread::sleep_for(std::chrono::duration<double>(kLongestWaitS));
    return now;
  }
  const int code = slipd_wait(slipd_.get(), settings_.name.c_str(), settings_.law.max_age_s,
                              std::min(settings_.law.max_age_s, kLongestWaitS), &now);
  if (code == SLIPD_ATTACH_ANEW || code == SLIPD_INVALID) attached_ = false;
  return now;
}

// A grasp's estimate has the sums; which finger slides is the finger's.
bool Controller::finger_slides() const {
  return std::ranges::any_of(settings_.fingers, [this](const std::string& finger) {
    slipd_estimate one{};
    slipd_latest(slipd_.get(), finger.c_str(), settings_.law.max_age_s, &one);
    return slides(one);
  });
}

void Controller::tell(const slipd_estimate& now, State before, double force_before_n) {
  if (law_.state() != before) {
    const bool grave =
        law_.state() == State::reacting || law_.state() == State::cut_off || law_.state() == State::firm;
    log(grave ? LogLevel::warning : LogLevel::info,
        std::string(to_string(before)) + " -> " + std::string(to_string(law_.state())) + ": " +
            std::string(to_string(law_.last_event())) + "; slipd says " + slipd_state_name(now.state) +
            ", margin " + (law_.margin() ? number(*law_.margin()) : "unknown") + ", force " +
            number(force_before_n) + " -> " + number(law_.force_n()) + " N");
  }
  if (law_.is_deaf() && !told_deaf_)
    log(LogLevel::error, "the gripper does not follow: " + number(law_.force_n()) +
                             " N a finger are ordered, and the sensors feel " + number(now.normal_n) +
                             " N together: look at the gripper, and at the sensors' calibration");
  told_deaf_ = law_.is_deaf();
}

void Controller::tell_trouble(const std::string& trouble) {
  if (trouble != told_trouble_ && !trouble.empty()) log(LogLevel::warning, trouble);
  told_trouble_ = trouble;
}

}  // namespace slipd::grip
