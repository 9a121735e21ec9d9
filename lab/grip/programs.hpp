// slipd and slipd-grip, the real programs, for one trial: in a folder of their own, with two pushed sensors
// of a grasp, and a gripper that this process plays on a socket.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <slipd.hpp>
#include <string>
#include <vector>

namespace lab::grip {

// A program that runs until this object ends. Its errors go to a file.
class Process {
 public:
  Process(const std::vector<std::string>& command, const std::filesystem::path& errors);
  ~Process() { kill(); }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  // At once, by SIGKILL.
  void kill() noexcept;
  // Stands still until it goes on.
  void stop() const noexcept;
  void go_on() const noexcept;

 private:
  pid_t pid_ = -1;
};

struct BedOptions {
  std::filesystem::path programs;  // the folder with slipd and slipd-grip
  std::filesystem::path modules;   // slipd's drivers
  int side = 5;                    // of a pad, taxels
  double pitch_m = 0.002;
  double dome_radius_m = 0.04;  // 0: told to be flat
  double half_width_m = 0.02;   // half of what is between the pads
  double rate_hz = 125;
  double target_margin = 0.35;
  bool firm_by_low = true;
  double firm_n = 25, most_n = 40;
  double resolution_n = 0.1;
  double delay_s = 0.02;
  std::filesystem::path keep;  // a folder for the logs; empty: none
};

// What slipd-grip ordered.
struct Ordered {
  std::string order;  // stay, open, grip
  double force_n = 0;
  std::uint64_t sequence = 0;
};

class Bed {
 public:
  // Throws std::runtime_error.
  explicit Bed(const BedOptions& options);
  ~Bed();
  Bed(const Bed&) = delete;
  Bed& operator=(const Bed&) = delete;

  // Sends a frame of each finger, in turn, and waits until slipd-grip has answered each: the programs and the
  // physics go in lockstep, so that a machine that is slow gives the same result. `width_m` is what the
  // gripper tells. Throws std::runtime_error if slipd-grip does not answer.
  Ordered exchange(const std::vector<float>& left, const std::vector<float>& right, double width_m);
  // What slipd says of the grasp now.
  slipd_estimate estimate();
  void order(const std::string& word);

  // For what is killed in mid-grasp.
  void restart_slipd();
  void restart_grip();
  Process& slipd() { return *slipd_; }
  Process& grip() { return *grip_; }
  void drop_gripper();
  // The gripper's end, without frames: the last order that has come within `patience`.
  Ordered hear(std::chrono::milliseconds patience, double width_m);
  std::string grip_log() const;
  // Frames go in again after slipd was away.
  bool push(const std::vector<float>& left, const std::vector<float>& right);

 private:
  void write_settings() const;
  void await_connection();
  void advance();
  void push_one(slipd::client::Source& source, const std::vector<float>& values, std::int64_t time_ns);
  Ordered await(std::uint64_t sequence, double width_m);
  bool read_order(std::chrono::steady_clock::time_point until, double width_m);

  BedOptions options_;
  std::filesystem::path folder_;
  int listener_ = -1, peer_ = -1;
  std::unique_ptr<Process> slipd_, grip_;
  std::unique_ptr<slipd::client::Source> left_, right_;
  slipd::client::Connection board_;
  std::int64_t time_ns_ = 0;  // of the last frame
  std::uint64_t frames_ = 0;
  std::string read_;
  Ordered ordered_;
  int starts_ = 0;
};

}  // namespace lab::grip
