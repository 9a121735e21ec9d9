// A client that subscribes to every estimate and counts, for each sensor, notifications received and
// reported as dropped, and incomplete lines. Handles thousands of lines a second.
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
  struct Counts {
    std::uint64_t events = 0;   // notifications received
    std::uint64_t frames = 0;   // notifications of another frame than the one before
    std::uint64_t dropped = 0;  // notifications that slipd reported as dropped
    std::uint64_t last_sequence = 0;
    std::string last_state;

    std::uint64_t published() const { return events + dropped; }
  };

  struct Latencies {
    std::vector<double> published_us, delivered_us;  // sample to published, sample to received here
  };

  // Subscribes with these parameters. Throws std::runtime_error if no process listens.
  explicit Subscriber(const std::filesystem::path& socket,
                      const nlohmann::json& params = nlohmann::json::object());
  ~Subscriber();
  Subscriber(const Subscriber&) = delete;
  Subscriber& operator=(const Subscriber&) = delete;

  // Waits, then reads what there is. False: nothing came, or the other end has closed.
  bool read(std::chrono::milliseconds patience, std::size_t most_bytes = 65536);

  const std::map<std::string, Counts>& counts() const { return counts_; }
  Counts total() const;  // of all sensors: losses are reported with the next notification of any sensor
  std::uint64_t broken_lines() const { return broken_; }  // lines that are not one JSON object
  Latencies take_latencies();  // any thread: latencies of the frames since the last call
  void keep_latencies() { keep_latencies_ = true; }

 private:
  void take_line(std::string_view line, std::int64_t now_ns);

  int fd_;
  std::string input_;
  std::map<std::string, Counts> counts_;
  std::uint64_t broken_ = 0;
  bool keep_latencies_ = false;
  std::mutex mutex_;  // guards latencies_
  Latencies latencies_;
};

// Reads in a thread of its own during its lifetime; meanwhile other threads may only take latencies.
// `pause`: before each read, to make a slow client.
class BackgroundReader {
 public:
  explicit BackgroundReader(Subscriber& subscriber,
                            std::chrono::milliseconds pause = std::chrono::milliseconds(0));

 private:
  std::jthread thread_;
};

}  // namespace slipd::testing
