#include "bridges/grip_ros2/gripper.hpp"

#include "bridges/grip_ros2/order_lines.hpp"
#include "bridges/support/clock.hpp"
#include "bridges/support/log.hpp"

namespace slipd::grip_ros2 {
namespace {

using bridges::log;
using bridges::LogLevel;

constexpr std::size_t kLongestOrder = 1024;
// What the fingers did longer ago is not told, ns.
constexpr std::int64_t kFreshNs = 1'000'000'000;

const char* type_name(ActionType type) {
  return type == ActionType::gripper_command ? "GripperCommand" : "ParallelGripperCommand";
}

}  // namespace

RosGripper::RosGripper(const Settings& settings, bridges::Loop& loop)
    : settings_(settings),
      cyclone_([](std::string_view) { return false; }),
      node_(settings.node),
      host_(loop, settings.node),
      action_(node_, settings.action),
      goals_(settings.goals),
      fingers_{},
      socket_(loop, settings.socket, [this](const std::string& line) { return obey(line); },
              {.longest_line = kLongestOrder,
               .most_peers = 1,
               .refusal = fault("another program commands this gripper: end it first")}) {
  node_.announce();
}

std::string RosGripper::obey(const std::string& line) {
  const std::optional<Order> order = order_of(line);
  if (!order) return fault("no order: expected {\"order\":\"grip\",\"force_n\":3}, \"open\" or \"stay\"");
  const std::int64_t now_ns = bridges::monotonic_ns();
  take(now_ns);
  if (server_) {
    if (const std::optional<Goal> goal = goals_.due(*order, now_ns)) {
      if (const std::optional<GoalId> id = action_.send(*goal))
        goals_.note_sent(*id, now_ns);
      else
        goals_.note_refused();
      told_abort_ = false;
    }
  }
  const std::string why = trouble(now_ns);
  tell(why);
  return why.empty() ? answer(now_ns) : fault(why);
}

void RosGripper::take(std::int64_t now_ns) {
  const bool server = action_.has_server();
  if (server != server_) {
    goals_.forget();
    fingers_ns_ = 0;
  }
  server_ = server;
  action_.take([this](const GoalStatus& status) { goals_.note_listed(status); },
               [this, now_ns](const Fingers& fingers) {
                 fingers_ = fingers;
                 fingers_ns_ = now_ns;
               });
}

std::string RosGripper::trouble(std::int64_t now_ns) const {
  if (server_) return goals_.trouble(now_ns);
  return "no node serves the action " + settings_.action.name + " of type control_msgs/action/" +
         type_name(settings_.action.type) +
         ": are its name and type right, and \"domain\" and \"network\" those of its node?";
}

void RosGripper::tell(const std::string& trouble) {
  if (trouble != told_) {
    if (trouble.empty())
      log(LogLevel::notice, "the gripper of " + settings_.action.name + " takes orders");
    else
      log(LogLevel::warning, trouble);
    told_ = trouble;
  }
  if (goals_.aborted() && !told_abort_) {
    log(LogLevel::notice, settings_.action.name +
                              " gave its goal up: it stalled on the object, or cannot move; where it lets go "
                              "then, allow it to stall (allow_stalling of gripper_action_controller)");
    told_abort_ = true;
  }
}

std::string RosGripper::answer(std::int64_t now_ns) const {
  if (fingers_ns_ == 0 || now_ns - fingers_ns_ > kFreshNs) return answer_of(std::nullopt, std::nullopt);
  const GoalSettings& goals = settings_.goals;
  std::optional<double> width_mm;
  if (settings_.stroke_mm)
    width_mm = (fingers_.position - goals.closed) / (goals.open - goals.closed) * *settings_.stroke_mm;
  return answer_of(width_mm, fingers_.effort / goals.effort_per_n);
}

}  // namespace slipd::grip_ros2
