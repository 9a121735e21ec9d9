// The method `frame`: the estimate thread copies the next frame, and each client that asked gets its text.
// Called from one thread: io.
#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "daemon/rpc/clients/client.hpp"
#include "daemon/rpc/protocol/owed_bytes.hpp"
#include "daemon/rpc/protocol/rpc.hpp"
#include "daemon/telemetry/service_context.hpp"

namespace slipd {

class FrameRequests {
 public:
  // `context` outlives it.
  explicit FrameRequests(ServiceContext& context);

  // Begins one. Throws rpc::Error.
  void add(Client& client, const nlohmann::json& params, const rpc::Reply& reply);
  // Responds to those whose copies are there, unless the time for such answers is used up: they get at most
  // half of the thread's. Then it returns when to call it again.
  std::optional<std::chrono::steady_clock::time_point> complete();
  // Responds to all with an error.
  void fail(const char* why);
  // Requests that were refused because slipd keeps too many answers that are not read.
  std::uint64_t refused() const noexcept { return refused_; }

 private:
  // The forms of a frame's text.
  enum class Encoding : std::uint8_t { digits, base64, bytes };
  static constexpr std::size_t kEncodings = 3;
  struct Pending {
    rpc::Reply reply;
    OwedPart promised;
    Encoding encoding;
  };
  static Encoding encoding_of(const nlohmann::json& params);
  void complete_of(std::size_t sensor);

  ServiceContext& context_;
  std::vector<std::vector<Pending>> pending_;     // per sensor
  std::chrono::steady_clock::time_point next_{};  // no frame is answered before
  std::uint64_t refused_ = 0;
};

}  // namespace slipd
