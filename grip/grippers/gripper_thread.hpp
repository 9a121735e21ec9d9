// The gripper in a thread of its own, which may wait for it: the newest command is what is sent, and commands
// that were replaced before are not. One that the gripper has lost is sent again. Functions are any thread's.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "grip/grippers/gripper.hpp"

namespace slipd::grip {

class GripperThread {
 public:
  // Throws std::system_error.
  explicit GripperThread(std::unique_ptr<Gripper> gripper);
  // What was commanded last stands: the gripper is neither opened nor released.
  ~GripperThread();
  GripperThread(const GripperThread&) = delete;
  GripperThread& operator=(const GripperThread&) = delete;

  void command(const Command& command);

  struct Condition {
    bool answers = true;
    // Why it does not; for people.
    std::string trouble;
    GripperFacts facts;
  };
  Condition condition() const;

 private:
  void run();
  struct Answer {
    std::optional<GripperFacts> facts;
    std::string trouble;  // empty: none
    bool stands = true;   // the connection
  };
  template <typename Question>
  Answer ask(std::unique_lock<std::mutex>& lock, Question question);
  bool is_obeyed(const Command& command) const;
  void attempt(std::unique_lock<std::mutex>& lock);
  void look(std::unique_lock<std::mutex>& lock);
  void succeed(const std::optional<GripperFacts>& facts);
  // connected: it answers, but does not obey.
  void fail(const std::string& what, bool connected);

  std::unique_ptr<Gripper> gripper_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Command> wanted_;
  std::optional<Command> obeyed_;
  Condition condition_;
  bool connected_ = false, busy_ = false;
  bool ended_ = false;
  std::thread thread_;  // the last: it uses the others
};

}  // namespace slipd::grip
