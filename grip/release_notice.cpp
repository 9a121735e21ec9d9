#include "grip/release_notice.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "bridges/support/log.hpp"

namespace slipd::grip {
namespace {

using bridges::log;
using bridges::LogLevel;

// Orders wait that long for slipd, s; the gripper has its own already.
constexpr double kTimeoutS = 0.1;

}  // namespace

ReleaseNotice::ReleaseNotice(const std::string& socket, std::vector<std::string> fingers)
    : slipd_(socket), fingers_(std::move(fingers)) {}

void ReleaseNotice::tell(double seconds) {
  for (const std::string& finger : fingers_) {
    if (seconds == 0 && released_.erase(finger) == 0) continue;
    try {
      slipd_.call("releasing", nlohmann::json{{"sensor", finger}, {"seconds", seconds}}.dump(), -1,
                  kTimeoutS);
      if (seconds == 0) continue;
      released_.insert(finger);
      log(LogLevel::info, "slipd takes it for no slip that \"" + finger + "\" is let go");
    } catch (const client::Error& error) {
      if (error.code() == SLIPD_REFUSED) continue;  // a finger that feels forces needs no word
      if (seconds == 0) return;                     // the release ends by itself
      log(LogLevel::warning, "slipd does not hear that \"" + finger +
                                 "\" is let go, and may take it for a slip: " + error.what());
      return;
    }
  }
}

}  // namespace slipd::grip
