// slipd-grip's loop, in a thread of its own: waits for slipd's estimates in shared memory, asks the law, and
// commands the gripper. Tells the journal each transition.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <slipd.hpp>
#include <string>
#include <thread>
#include <vector>

#include "grip/gripper_watch.hpp"
#include "grip/grippers/gripper_thread.hpp"
#include "grip/law.hpp"
#include "grip/settings.hpp"

namespace slipd::grip {

class Controller {
 public:
  // Throws GripperError, std::system_error.
  explicit Controller(const Settings& settings);
  // The gripper keeps the last order.
  ~Controller();
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  // Any thread.
  void wish(Wish wish) { wish_.store(wish, std::memory_order_relaxed); }
  // What it does, and why: a JSON object. Any thread.
  nlohmann::json status() const;

 private:
  void run();
  void step();
  void attach();
  slipd_estimate wait_for_estimate();
  bool finger_slides() const;
  void tell(const slipd_estimate& now, State before, double force_before_n);
  void tell_trouble(const std::string& trouble);

  Settings settings_;
  client::Connection slipd_;
  Law law_;
  GripperThread gripper_;
  GripperWatch watch_;
  std::string told_trouble_;  // of the watch
  bool attached_ = false;
  std::string slipd_trouble_;  // why it is not attached
  std::chrono::steady_clock::time_point attach_at_;
  std::chrono::milliseconds attach_pause_{0};
  bool told_deaf_ = false;
  std::atomic<Wish> wish_{Wish::none};  // relaxed: an independent value
  std::atomic<bool> ended_{false};      // relaxed: an independent value
  mutable std::mutex mutex_;            // of status_
  nlohmann::json status_;
  std::thread thread_;  // the last: it uses the others
};

}  // namespace slipd::grip
