#include "bridges/grip_ros2/action.hpp"

#include <algorithm>
#include <random>

#include "bridges/grip_ros2/samples.hpp"
#include "bridges/ros2/messages/cdr.hpp"

namespace slipd::grip_ros2 {
namespace {

using ros2::ReaderOptions;
using ros2::Subscription;

// QoS that ROS 2 gives actions: services, feedback and the list of goals.
constexpr ros2::WriterOptions kRequests{.depth = 10, .reliable = true, .prefix = "rq"};
constexpr ReaderOptions kFeedback{.depth = 10, .reliable = true};
constexpr ReaderOptions kStatus{.depth = 1, .reliable = true, .transient = true};

// RFC 9562, version 4.
GoalId new_goal_id() {
  std::random_device device;
  GoalId id;
  for (std::uint8_t& byte : id.uuid) byte = static_cast<std::uint8_t>(device());
  id.uuid[6] = static_cast<std::uint8_t>((id.uuid[6] & 0x0F) | 0x40);
  id.uuid[8] = static_cast<std::uint8_t>((id.uuid[8] & 0x3F) | 0x80);
  return id;
}

std::uint64_t new_client() {
  std::random_device device;
  return std::uint64_t{device()} << 32 | device();
}

void fill(GripperGoal& to, const ActionSettings& /*settings*/, const GoalId& id, const Goal& goal) {
  to = {.goal_id = id, .position = goal.position, .max_effort = goal.effort};
}

void fill(ParallelGoal& to, const ActionSettings& settings, const GoalId& id, const Goal& goal) {
  to.goal_id = id;
  to.command.name = {settings.joint};
  to.command.position = {goal.position};
  to.command.effort = {goal.effort};
}

template <class G>
void fill(CountedRequest<G>& to, const ActionSettings& settings, const GoalId& id, const Goal& goal) {
  ++to.number;
  fill(to.goal, settings, id, goal);
}

double at(const std::vector<double>& numbers, std::size_t joint) {
  return joint < numbers.size() ? numbers[joint] : ros2::kUnknown;
}

// Of the joint, or of the first if the driver has others.
Fingers fingers_of(const JointState& state, const std::string& joint) {
  const auto found = std::ranges::find(state.name, joint);
  const auto index = found == state.name.end() ? 0 : static_cast<std::size_t>(found - state.name.begin());
  return {at(state.position, index), at(state.effort, index)};
}

Subscription feedback_of(ros2::Node& node, const ActionSettings& settings) {
  const std::string topic = settings.name + "/_action/feedback";
  return settings.type == ActionType::gripper_command
             ? Subscription::of<GripperFeedback>(node, topic, kFeedback)
             : Subscription::of<ParallelFeedback>(node, topic, kFeedback);
}

}  // namespace

struct GripperAction::Request {
  virtual ~Request() = default;
  virtual bool has_server() const = 0;
  virtual bool send(const ActionSettings& settings, const GoalId& id, const Goal& goal) = 0;
};

template <class T>
struct GripperAction::RequestOf final : Request {
  RequestOf(ros2::Node& node, const ActionSettings& settings)
      : writer(node, settings.name + "/_action/send_goalRequest", kRequests) {
    if constexpr (requires { message.client; }) message.client = new_client();
  }
  bool has_server() const override { return writer.has_readers(); }
  bool send(const ActionSettings& settings, const GoalId& id, const Goal& goal) override {
    fill(message, settings, id, goal);
    return writer.write(message);
  }
  T message;
  ros2::Writer<T> writer;
};

std::unique_ptr<GripperAction::Request> GripperAction::make_request(ros2::Node& node,
                                                                    const ActionSettings& settings) {
  const bool counted = settings.middleware == Middleware::cyclonedds;
  if (settings.type == ActionType::gripper_command) {
    if (counted) return std::make_unique<RequestOf<CountedRequest<GripperGoal>>>(node, settings);
    return std::make_unique<RequestOf<GripperGoal>>(node, settings);
  }
  if (counted) return std::make_unique<RequestOf<CountedRequest<ParallelGoal>>>(node, settings);
  return std::make_unique<RequestOf<ParallelGoal>>(node, settings);
}

GripperAction::GripperAction(ros2::Node& node, const ActionSettings& settings)
    : settings_(settings),
      request_(make_request(node, settings)),
      status_(Subscription::of<GoalStatusArray>(node, settings.name + "/_action/status", kStatus)),
      feedback_(feedback_of(node, settings)) {}

GripperAction::~GripperAction() = default;

bool GripperAction::has_server() const {
  return request_->has_server();
}

std::optional<GoalId> GripperAction::send(const Goal& goal) {
  const GoalId id = new_goal_id();
  if (!request_->send(settings_, id, goal)) return std::nullopt;
  return id;
}

void GripperAction::take(const std::function<void(const GoalStatus&)>& status,
                         const std::function<void(const Fingers&)>& feedback) {
  status_.take([&](const ros2::TakenSample& sample) {
    if (!ros2::decode(sample.cdr, list_)) return;
    for (const GoalStatus& one : list_.status_list) status(one);
  });
  feedback_.take([&](const ros2::TakenSample& sample) {
    if (settings_.type == ActionType::gripper_command) {
      if (ros2::decode(sample.cdr, gripper_feedback_))
        feedback({gripper_feedback_.position, gripper_feedback_.effort});
    } else if (ros2::decode(sample.cdr, parallel_feedback_)) {
      feedback(fingers_of(parallel_feedback_.state, settings_.joint));
    }
  });
}

}  // namespace slipd::grip_ros2
