#include "bridges/feed_lane/report.hpp"

#include <utility>

namespace slipd::feed {
namespace {

using bridges::LogLevel;

std::string counted(const Account& before, const Account& now) {
  const std::pair<const char*, std::uint64_t> kinds[] = {{"corrupt", now.corrupt - before.corrupt},
                                                         {"repeated", now.repeated - before.repeated},
                                                         {"lost", now.lost - before.lost},
                                                         {"of a second sender", now.second - before.second},
                                                         {"overtaken", now.overtaken - before.overtaken},
                                                         {"not taken by slipd", now.unsent - before.unsent}};
  std::string text;
  for (const auto& [name, count] : kinds)
    if (count > 0) text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + name;
  return text;
}

}  // namespace

std::vector<Line> report(const std::string& sensor, const Account& before, const Account& now) {
  std::vector<Line> lines;
  const auto told = [&](bool changed, const std::string& is, const char* fine) {
    if (changed)
      lines.push_back(
          {is.empty() ? LogLevel::notice : LogLevel::warning, sensor + ": " + (is.empty() ? fine : is)});
  };
  // It may have come and gone in between.
  told(before.source != now.source || before.losses != now.losses, now.source, "the source is there");
  told(before.trouble != now.trouble, now.trouble, "slipd takes the frames");
  if (const std::string counts = counted(before, now); !counts.empty())
    lines.push_back(
        {LogLevel::warning, sensor + ": " + counts + (now.why.empty() ? "" : "; the last one: " + now.why)});
  const bool useless =
      now.messages > before.messages && now.other - before.other == now.messages - before.messages;
  if (useless && now.why != before.why)
    lines.push_back({LogLevel::warning, sensor + ": no frame: " + now.why});
  return lines;
}

std::string summary(const std::string& sensor, const Account& now) {
  return sensor + ": " + std::to_string(now.messages) + " messages, " + std::to_string(now.sent) +
         " frames sent, " + std::to_string(now.other) + " other, " + std::to_string(now.corrupt) +
         " corrupt, " + std::to_string(now.repeated) + " repeated, " + std::to_string(now.lost) + " lost, " +
         std::to_string(now.overtaken) + " overtaken, " + std::to_string(now.unsent) +
         " not taken by slipd, " + std::to_string(now.second) + " of a second sender";
}

}  // namespace slipd::feed
