// A daemon's end of the socket, in a thread of the test: it sends the answers that the test sets.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "core/storage/unique_fd.hpp"

namespace slipctl::testing {

// A received line, and the descriptor that goes with the answer to it; none at first.
struct Asked {
  std::string line;
  slipd::UniqueFd& passing;
};

class FakeDaemon {
 public:
  // The bytes of the answer. Empty: no answer. nullopt: closes the connection.
  using Answer = std::function<std::optional<std::string>(const Asked&)>;

  explicit FakeDaemon(Answer answer);
  ~FakeDaemon();
  FakeDaemon(const FakeDaemon&) = delete;
  FakeDaemon& operator=(const FakeDaemon&) = delete;
  const std::string& path() const { return path_; }

 private:
  void serve();
  void converse(int client);
  Answer answer_;
  std::string folder_, path_;
  slipd::UniqueFd listening_, stop_;
  std::thread thread_;
};

// A result for the request in `line`, by its id.
std::string result_line(const std::string& line, const nlohmann::json& result);
std::string error_line(const std::string& line, int code, const std::string& message);

// Answers by method, as slipd does: an unknown method is error -32601.
FakeDaemon::Answer by_method(
    std::map<std::string, std::function<nlohmann::json(const nlohmann::json& params)>> methods);

// Answers to `record` with a recording of these bytes, and tells its end. `trouble`: null or text.
std::string recording_line(const Asked& asked, const std::string& bytes,
                           const nlohmann::json& trouble = nullptr);

// A path in a new folder of its own.
std::string temporary_folder();

}  // namespace slipctl::testing
