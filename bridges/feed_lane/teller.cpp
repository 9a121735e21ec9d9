#include "bridges/feed_lane/teller.hpp"

#include <systemd/sd-daemon.h>

#include <chrono>
#include <string>
#include <utility>

#include "bridges/feed_lane/report.hpp"
#include "bridges/support/log.hpp"

namespace slipd::feed {
namespace {

constexpr std::chrono::seconds kReportPeriod{2};

}  // namespace

Teller::Teller(bridges::Loop& loop, const std::vector<std::unique_ptr<Lane>>& lanes)
    : lanes_(lanes), report_(loop, [this] { tell(); }) {
  report_.start(kReportPeriod);
}

Teller::~Teller() {
  for (const auto& lane : lanes_)
    bridges::log(bridges::LogLevel::info, summary(lane->sensor(), lane->account()));
}

void Teller::tell() {
  if (lanes_.empty()) {
    bridges::log(bridges::LogLevel::warning, "the settings have no feeds: nothing to do");
    return;
  }
  told_.resize(lanes_.size());
  std::string status;
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    Account now = lanes_[i]->account();
    for (const Line& line : report(lanes_[i]->sensor(), told_[i], now)) bridges::log(line.level, line.text);
    status += (status.empty() ? "" : "; ") + lanes_[i]->sensor() + " " +
              std::to_string(now.sent - told_[i].sent) + " frames";
    told_[i] = std::move(now);
  }
  sd_notifyf(0, "STATUS=In the last %d s: %s", static_cast<int>(kReportPeriod.count()), status.c_str());
  report_.start(kReportPeriod);
}

}  // namespace slipd::feed
