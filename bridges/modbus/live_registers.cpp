#include "bridges/modbus/live_registers.hpp"

#include <utility>

#include "bridges/support/clock.hpp"
#include "bridges/support/log.hpp"

namespace slipd::modbus {
namespace {

using bridges::log;
using bridges::LogLevel;

// slipd's last sign of life may be this old, s; it is less than 20 ms old while slipd works.
constexpr double kAliveWithin = 0.2;
constexpr std::int64_t kNsPerMillisecond = 1'000'000;

}  // namespace

LiveRegisters::LiveRegisters(bridges::Loop& loop, const std::string& socket, std::vector<std::string> blocks,
                             double max_age_s)
    : names_(std::move(blocks)),
      names_are_slipds_(names_.empty()),
      max_age_s_(max_age_s),
      slipd_(socket),
      finder_(loop, socket,
              {.found = [this](FoundBoard&& board) { take(std::move(board)); },
               .away = [this](const std::string& why) { go_away(why); }}) {}

void LiveRegisters::take(FoundBoard&& board) {
  slipd_ = std::move(board.slipd);
  told_away_ = false;
  const bridges::Inventory& all = board.inventory;
  std::size_t wanted = names_.size();
  if (names_are_slipds_) {
    names_.clear();
    for (const auto& sensor : all.sensors) names_.push_back(sensor.name);
    for (const auto& grasp : all.grasps) names_.push_back(grasp.name);
    wanted = names_.size();
    if (wanted > std::size_t{kMostBlocks}) names_.resize(kMostBlocks);
  }
  log(LogLevel::notice, "slipd " + all.version + " has " + std::to_string(all.sensors.size()) +
                            " sensors and " + std::to_string(all.grasps.size()) + " grasps; " +
                            std::to_string(names_.size()) + " blocks are in use");
  tell_unknown(all);
  if (wanted > names_.size())
    log(LogLevel::warning, "only " + std::to_string(kMostBlocks) + " of " + std::to_string(wanted) +
                               " sensors and grasps have a block; choose them with \"blocks\"");
}

// Names that slipd does not have, when they are others than before.
void LiveRegisters::tell_unknown(const bridges::Inventory& all) {
  std::string unknown;
  for (const std::string& name : names_)
    if (!all.has(name)) unknown += (unknown.empty() ? "\"" : ", \"") + name + "\"";
  if (std::exchange(told_unknown_, unknown) == unknown || unknown.empty()) return;
  log(LogLevel::warning, "slipd has no sensor or grasp " + unknown +
                             ": such a block reads state 8; correct \"blocks\", or slipd's configuration");
}

void LiveRegisters::go_away(const std::string& why) {
  if (!std::exchange(told_away_, true)) log(LogLevel::warning, why);
}

bool LiveRegisters::alive() {
  const bool alive = slipd_heartbeat_age(slipd_.get()) < kAliveWithin;
  if (!alive) finder_.look();
  return alive;
}

void LiveRegisters::write(std::span<std::uint16_t> registers) {
  const bool works = alive();
  if (works) alive_ms_ = bridges::monotonic_ns() / kNsPerMillisecond;
  write_header({works, alive_ms_, static_cast<int>(names_.size())}, registers);
  slipd_estimate nothing;
  slipd_latest(slipd_.get(), "", 0, &nothing);  // nobody has this name
  for (std::size_t i = 0; i < std::size_t{kMostBlocks}; ++i) {
    slipd_estimate estimate = nothing;
    if (i < names_.size()) slipd_latest(slipd_.get(), names_[i].c_str(), works ? max_age_s_ : 0, &estimate);
    if (!works) estimate.state = SLIPD_STATE_DISCONNECTED;
    write_block(estimate, registers.subspan(kFirstBlock + i * kBlockSize, kBlockSize));
  }
}

}  // namespace slipd::modbus
