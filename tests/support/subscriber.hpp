// A client that subscribes to every estimate and counts: notifications of each sensor, those that slipd
// reported as dropped, and incomplete lines. Fast enough for thousands of lines a second.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

namespace slipd::testing {

class Subscriber {
 public:
  struct Told {
    std::uint64_t events = 0;   // notifications received
    std::uint64_t frames = 0;   // those among them that tell of another frame than the one before
    std::uint64_t dropped = 0;  // notifications that slipd reported as dropped
    std::uint64_t last_sequence = 0;
    std::string last_state;

    std::uint64_t published() const { return events + dropped; }
  };

  struct Latencies {
    std::vector<double> published_us, told_us;  // sample → published, sample → here
  };

  // Subscribes with these parameters. Throws std::runtime_error if nobody listens.
  explicit Subscriber(const std::filesystem::path& socket,
                      const nlohmann::json& params = nlohmann::json::object());
  ~Subscriber();
  Subscriber(const Subscriber&) = delete;
  Subscriber& operator=(const Subscriber&) = delete;

  // Reads once what there is, after waiting for it; false: nothing came, or the other end has closed.
  bool read(std::chrono::milliseconds patience, std::size_t most_bytes = 65536);

  const std::map<std::string, Told>& told() const { return told_; }
  Told total() const;  // of all sensors: losses are reported with the next notification of any sensor
  std::uint64_t broken_lines() const { return broken_; }  // lines that were not one JSON object
  Latencies take_latencies();  // any thread: of each frame since they were last taken
  void keep_latencies() { keep_latencies_ = true; }

 private:
  void take_line(std::string_view line, std::int64_t now_ns);

  int fd_;
  std::string input_;
  std::map<std::string, Told> told_;
  std::uint64_t broken_ = 0;
  bool keep_latencies_ = false;
  std::mutex mutex_;  // latencies_
  Latencies latencies_;
};

// Reads in its own thread during its lifetime; meanwhile other threads may only take latencies.
// `pause`: before each read, for a client that is slow.
class Reading {
 public:
  explicit Reading(Subscriber& subscriber, std::chrono::milliseconds pause = std::chrono::milliseconds(0));

 private:
  std::jthread thread_;
};

}  // namespace slipd::testing
