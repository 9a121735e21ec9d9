#include "grip/grippers/gripper_thread.hpp"

#include <chrono>
#include <utility>

#include "bridges/support/log.hpp"

namespace slipd::grip {
namespace {

using bridges::log;
using bridges::LogLevel;
using Clock = std::chrono::steady_clock;

// Between attempts to reach a gripper that does not answer.
constexpr std::chrono::milliseconds kRetry{100};
// Between attempts to order a gripper that is busy.
constexpr std::chrono::milliseconds kBusyRetry{10};
// Between looks at a gripper that has no new order. Longer: its loss is told later. Shorter: an order waits
// for a look more often.
constexpr std::chrono::milliseconds kLook{100};

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
  auto look_at = Clock::now();
  for (;;) {
    const auto due = [this] { return ended_ || wanted_; };
    if (connected_ && !gripper_->wants_each())
      changed_.wait_until(lock, look_at, due);
    else
      changed_.wait(lock, due);
    if (ended_) return;
    const auto now = Clock::now();
    if (wanted_ && !is_obeyed(*wanted_)) {
      attempt(lock);
      look_at = now + kLook;
    } else if (wanted_.reset(); now >= look_at) {
      look(lock);
      look_at = now + kLook;
    }
    if (!condition_.answers) changed_.wait_for(lock, kRetry, [this] { return ended_; });
    if (busy_) changed_.wait_for(lock, kBusyRetry, [this] { return ended_; });
  }
}

bool GripperThread::is_obeyed(const Command& command) const {
  return connected_ && condition_.answers && obeyed_ && obeyed_->order == command.order &&
         !gripper_->wants_each();
}

// Without the lock while the gripper is waited for.
template <typename Question>
GripperThread::Answer GripperThread::ask(std::unique_lock<std::mutex>& lock, Question question) {
  Answer answer;
  lock.unlock();
  try {
    answer.facts = question();
  } catch (const std::exception& error) {
    answer.trouble = error.what();
    answer.stands = dynamic_cast<const GripperFault*>(&error) != nullptr;
  }
  lock.lock();
  return answer;
}

// Sends what is wanted now. A command that failed is wanted until there is a newer one.
void GripperThread::attempt(std::unique_lock<std::mutex>& lock) {
  const Command command = *std::exchange(wanted_, std::nullopt);
  const bool connected = connected_;
  const auto [facts, trouble, stands] = ask(lock, [&] {
    if (!connected) gripper_->connect();
    return gripper_->obey(command);
  });
  if (facts) obeyed_ = command;
  if (!facts && !wanted_) wanted_ = command;
  if (trouble.empty())
    succeed(facts);
  else
    fail(trouble, stands);
}

// What it has lost of the last command is wanted again.
void GripperThread::look(std::unique_lock<std::mutex>& lock) {
  const Command last = *obeyed_;
  const auto [facts, trouble, stands] = ask(lock, [&] { return std::optional(gripper_->look(last)); });
  if (facts) {
    condition_.facts = *facts;
    return;
  }
  if (!wanted_) wanted_ = last;
  fail(trouble, stands);
}

void GripperThread::succeed(const std::optional<GripperFacts>& facts) {
  if (!condition_.answers) log(LogLevel::notice, "the gripper answers again");
  connected_ = true;
  busy_ = !facts;
  condition_ = {.answers = true, .trouble = {}, .facts = facts.value_or(condition_.facts)};
}

void GripperThread::fail(const std::string& what, bool connected) {
  if (condition_.trouble != what) log(LogLevel::error, what);
  connected_ = connected;
  busy_ = false;
  condition_.answers = false;
  condition_.trouble = what;
}

}  // namespace slipd::grip
