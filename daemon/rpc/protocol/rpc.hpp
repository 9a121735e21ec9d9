// JSON-RPC 2.0 without a socket: parses lines into requests, builds responses. Called from one thread: io. No
// input makes it throw, and nesting is limited before anything is parsed.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/rpc/protocol/owed_bytes.hpp"

namespace slipd::rpc {

// Error codes: those of JSON-RPC, and slipd's own from -32000 on.
inline constexpr int kParseError = -32700;
inline constexpr int kInvalidRequest = -32600;
inline constexpr int kMethodNotFound = -32601;
inline constexpr int kInvalidParams = -32602;
inline constexpr int kInternalError = -32603;
inline constexpr int kTooManyClients = -32000;
inline constexpr int kUnknownSensor = -32001;
inline constexpr int kNotPermitted = -32002;
inline constexpr int kNotPossible = -32003;
inline constexpr int kTooMuch = -32004;

// Longest line, bytes.
inline constexpr std::size_t kLongestLine = std::size_t{64} * 1024;
// Deepest nesting of arrays and objects.
inline constexpr int kDeepestNesting = 32;
// Most requests in a batch.
inline constexpr std::size_t kLargestBatch = 64;

// Thrown by a method; becomes an error response. what() is its message.
class Error : public std::runtime_error {
 public:
  Error(int code, const std::string& message) : std::runtime_error(message), code_(code) {}
  // One of the codes above.
  int code() const noexcept { return code_; }

 private:
  int code_;
};

// Id of a response to a request whose id could not be read.
inline constexpr const char* kNoId = "null";

// One request of a line.
struct Request {
  // The method's name.
  std::string method;
  // An object; empty if there were none.
  nlohmann::json params;
  // The id as JSON.
  std::string id = kNoId;
  // Whether it has no id and so gets no response.
  bool notification = false;
  // For what is not a valid request, its response: an error, or empty for a notification. None: it is valid.
  std::optional<std::string> error_response;
};

// A parsed line.
struct Line {
  // Whether it is an array of requests.
  bool batch = false;
  // At least one, unless error_response is set.
  std::vector<Request> requests;
  // The response to a line that cannot be parsed; empty: it could.
  std::string error_response;
};

// Parses one line, without its end.
Line parse(std::string_view text);

// Responses without the end of line. Bytes that are not UTF-8 are replaced. `result`: JSON.
std::string result_text(const std::string& id, std::string_view result);
std::string error_text(const std::string& id, int code, const std::string& message);

// Collects the responses to one line and hands them on as one text when the last is there: an object, or an
// array for a batch. Empty if all requests were notifications. Not thread-safe.
class Responses {
 public:
  // `expected`: number of requests, at least 1. `done`: called once. `owed`: grows by what is collected.
  Responses(bool batch, std::size_t expected, std::function<void(std::string)> done, OwedPart owed = {});
  // One response; empty: a notification's.
  void add(std::string text);

 private:
  bool batch_;
  std::size_t missing_;
  std::string collected_;
  std::function<void(std::string)> done_;
  OwedPart owed_;
};

// Responds to one request, at once or later. Exactly one of its functions is to be called, once. Not
// thread-safe.
class Reply {
 public:
  Reply(const Request& request, std::shared_ptr<Responses> answers);
  void result(const nlohmann::ordered_json& value) const;
  // A result that is JSON text already.
  void text(std::string_view json) const;
  void error(int code, const std::string& message) const;

 private:
  std::string id_;
  bool notification_;
  std::shared_ptr<Responses> answers_;
};

}  // namespace slipd::rpc
