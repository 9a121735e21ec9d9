// What one client wants to be told, and when it was last told. io thread.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/estimate/estimate.hpp"
#include "daemon/board/board.hpp"

namespace slipd {

// What happened to a sensor, seen from the estimate before.
enum class EventKind : std::uint8_t { estimate, alert, state };
inline constexpr std::size_t kEventKinds = 3;

class Subscription {
 public:
  // `params` of the method `subscribe`: sensors (all), max_rate_hz (no limit), events (estimate). Throws
  // rpc::Error for what it does not understand.
  Subscription(int id, const nlohmann::json& params, const Board& board);

  int id() const noexcept { return id_; }

  // The sensors are those of another board from now on. Those it wanted by name it gets if they are still
  // there.
  void follow(const Board& board);

  // Whether to tell of it now. An estimate is thinned to max_rate_hz, unless its state has changed since the
  // last one told: so the last word a client hears is never an old state. Adds up in `lost` what was lost
  // since the last one told.
  bool wants(const Event& event, EventKind kind, std::uint64_t& lost);

 private:
  struct Told {
    bool wanted = false;
    bool any = false;
    State state = State::stale;
    std::int64_t due_ns = 0;
    std::uint64_t lost = 0;
  };
  int id_;
  std::int64_t interval_ns_ = 0;
  bool events_[kEventKinds] = {};
  std::optional<std::vector<std::string>> names_;  // none: all sensors
  std::vector<Told> sensors_;
};

}  // namespace slipd
