// A client's subscription: which events it gets, and how often.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/estimate/estimate.hpp"
#include "daemon/board/board.hpp"

namespace slipd {

// Kinds of notifications.
enum class EventKind : std::uint8_t {
  estimate,  // any estimate
  alert,     // its alert differs from the estimate before
  state      // its state differs from the estimate before
};
inline constexpr std::size_t kEventKinds = 3;

// Not thread-safe. Called from one thread: io.
class Subscription {
 public:
  // `params` of the method `subscribe`: sensors (absent: all), max_rate_hz (absent: no limit), events
  // (absent: estimate). Throws rpc::Error.
  Subscription(int id, const nlohmann::json& params, const Board& board);

  // Number within its client, from 1.
  int id() const noexcept { return id_; }

  // Applies the subscription to the sensors of another board. Sensors selected by name are matched by name.
  void rebind(const Board& board);

  // Whether it is of this kind and of the sensor of this name, which need not be on the board.
  bool wants(const std::string& sensor, EventKind kind) const;

  // Whether to send this event now. Estimates are thinned to max_rate_hz; one whose state differs from the
  // last one sent is always sent, so that the client's last estimate never has an old state. Sets `lost` to
  // the events lost since the last one sent.
  bool accepts(const Event& event, EventKind kind, std::uint64_t& lost);

 private:
  struct Delivery {
    bool wanted = false;
    bool sent_any = false;
    State state = State::stale;
    std::int64_t next_due_ns = 0;
    std::uint64_t lost = 0;
  };
  bool selects(const std::string& sensor) const;

  int id_;
  std::int64_t interval_ns_ = 0;
  bool events_[kEventKinds] = {};
  std::optional<std::vector<std::string>> names_;  // none: all sensors
  std::vector<Delivery> sensors_;
};

}  // namespace slipd
