// A client of slipd's socket for tests: lines, requests, descriptors both ways. Every wait has a deadline.
#pragma once

#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <deque>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "core/storage/unique_fd.hpp"
#include "tests/support/patience.hpp"

namespace slipd::testing {

class RpcClient {
 public:
  // The other end has closed, or has sent nothing for kPatience.
  class NoAnswer : public std::runtime_error {
   public:
    using std::runtime_error::runtime_error;
  };

  explicit RpcClient(const std::filesystem::path& socket);  // throws std::runtime_error if no process listens
  ~RpcClient();
  RpcClient(const RpcClient&) = delete;
  RpcClient& operator=(const RpcClient&) = delete;

  // Sends all of `bytes`, or as much as the other end takes; false if it has closed.
  bool send(const std::string& bytes, int descriptor = -1);
  bool send_line(const std::string& line) { return send(line + "\n"); }

  void finish();  // sends no more, still reads
  int fd() const { return fd_; }

  // The next line without its end; none if the other end closed first or time ran out.
  std::optional<std::string> line(std::chrono::milliseconds patience = kPatience);
  bool closed_by_peer(
      std::chrono::milliseconds patience = kPatience);  // waits at most this long; lines are discarded

  // The whole answer to one request; notifications before it are kept. Throws std::runtime_error if none
  // comes.
  nlohmann::json call(const std::string& method, const nlohmann::json& params = nlohmann::json::object(),
                      int descriptor = -1);
  nlohmann::json result(const std::string& method, const nlohmann::json& params = nlohmann::json::object());

  // The next notification. Throws std::runtime_error if none comes.
  nlohmann::json notification();

  // The descriptor that came last with a line; none: none has come since.
  UniqueFd take_descriptor() { return std::move(passed_); }

  // Records into a new file to the end, and returns the params of `recorded`, or the answer if it is an
  // error.
  nlohmann::json record(const std::string& sensor, double seconds, const std::filesystem::path& file);

 private:
  int fd_;
  int next_id_ = 0;
  std::string input_;
  UniqueFd passed_;
  std::deque<nlohmann::json> notifications_;
  bool ended_ = false;
};

// Writes all that comes from the other end into a new file, as it comes; nothing without a descriptor.
void copy_to_end(UniqueFd from, const std::filesystem::path& file);

// The same in a thread, until the other end closes.
class Copying {
 public:
  Copying(UniqueFd from, const std::filesystem::path& file)
      : from_(std::move(from)), thread_([this, file] { copy_to_end(UniqueFd(dup(from_.get())), file); }) {}
  ~Copying() {
    shutdown(from_.get(), SHUT_RD);
    thread_.join();
  }
  Copying(const Copying&) = delete;
  Copying& operator=(const Copying&) = delete;

 private:
  UniqueFd from_;
  std::thread thread_;
};

}  // namespace slipd::testing
