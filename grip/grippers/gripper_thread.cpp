#include "grip/grippers/gripper_thread.hpp"

#include <chrono>
#include <utility>

#include "bridges/support/log.hpp"

namespace slipd::grip {
namespace {

using bridges::log;
using bridges::LogLevel;

// Between attempts to reach a gripper that does not answer.
constexpr std::chrono::milliseconds kRetry{100};
// Between attempts to order a gripper that is busy.
constexpr std::chrono::milliseconds kBusyRetry{10};

}  // namespace

GripperThread::GripperThread(std::unique_ptr<Gripper> gripper)
    : gripper_(std::move(gripper)), thread_([this] { run(); }) {}

GripperThread::~GripperThread() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void GripperThread::command(const Command& command) {
  {
    const std::lock_guard lock(mutex_);
    wanted_ = command;
  }
  changed_.notify_one();
}

GripperThread::Condition GripperThread::condition() const {
  const std::lock_guard lock(mutex_);
  return condition_;
}

void GripperThread::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return ended_ || wanted_; });
    if (ended_) return;
    attempt(lock);
    if (!connected_) changed_.wait_for(lock, kRetry, [this] { return ended_; });
    if (busy_) changed_.wait_for(lock, kBusyRetry, [this] { return ended_; });
  }
}

// Sends what is wanted now. A command that failed is wanted until there is a newer one.
void GripperThread::attempt(std::unique_lock<std::mutex>& lock) {
  const Command command = *std::exchange(wanted_, std::nullopt);
  if (connected_ && obeyed_ == command.order && !gripper_->wants_each()) return;
  const bool connected = connected_;
  lock.unlock();
  std::optional<GripperFacts> facts;
  std::string trouble;
  try {
    if (!connected) gripper_->connect();
    facts = gripper_->obey(command);
  } catch (const GripperError& error) {
    trouble = error.what();
  }
  lock.lock();
  if (facts) obeyed_ = command.order;
  if (!facts && !wanted_) wanted_ = command;
  if (trouble.empty())
    succeed(facts);
  else
    fail(trouble);
}

void GripperThread::succeed(const std::optional<GripperFacts>& facts) {
  if (!condition_.answers) log(LogLevel::notice, "the gripper answers again");
  connected_ = true;
  busy_ = !facts;
  condition_ = {.answers = true, .trouble = {}, .facts = facts.value_or(condition_.facts)};
}

void GripperThread::fail(const std::string& what) {
  if (condition_.trouble != what) log(LogLevel::error, what);
  connected_ = busy_ = false;
  condition_.answers = false;
  condition_.trouble = what;
}

}  // namespace slipd::grip
