#include "daemon/can/dbc.hpp"

#include <algorithm>
#include <sstream>

#include "daemon/can/encode.hpp"
#include "embedded/slipd_dbc.hpp"

namespace slipd::can {
namespace {

// Identifiers and texts of the file as shipped.
constexpr std::uint32_t kShippedBase = 0x5A0;
constexpr std::string_view kShippedSubject = "sensor 0 of the configuration";
constexpr std::uint32_t kExtendedMark = 0x80000000;

bool in_word(char c) {
  return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
}

std::size_t find_word(std::string_view text, std::string_view word) {
  for (std::size_t at = text.find(word); at != std::string_view::npos; at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    if ((at == 0 || !in_word(text[at - 1])) && (end == text.size() || !in_word(text[end]))) return at;
  }
  return std::string_view::npos;
}

std::string replaced(std::string text, std::string_view what, const std::string& by) {
  if (const std::size_t at = text.find(what); at != std::string::npos) text.replace(at, what.size(), by);
  return text;
}

// Splits into statements: a message with its signals, or one line.
std::vector<std::string> statements(std::string_view text) {
  std::vector<std::string> all;
  std::istringstream in{std::string(text)};
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with(" SG_")) {
      all.back() += line + '\n';
    } else {
      all.push_back(line + '\n');
    }
  }
  return all;
}

std::string frame_format(const CanSettings& can) {
  return std::to_string((can.fd ? 14 : 0) + (can.extended ? 1 : 0));
}

class Instance {
 public:
  Instance(const CanSettings& can, std::uint32_t shipped_id) : can_(can), shipped_id_(shipped_id) {}

  // Whether a statement is about a message of this kind.
  bool about(const std::string& statement) const {
    return find_word(statement, std::to_string(shipped_id_)) != std::string::npos;
  }

  // The statement for message `index`; empty: it is about another message.
  std::string of(const std::string& statement, std::size_t index, const std::string& source) const {
    const std::string shipped = std::to_string(shipped_id_);
    const std::size_t at = find_word(statement, shipped);
    if (at == std::string::npos) return {};
    const std::uint32_t id = can_.base_id + (shipped_id_ - kShippedBase) + static_cast<std::uint32_t>(index);
    std::string text = statement;
    text.replace(at, shipped.size(), std::to_string(can_.extended ? id | kExtendedMark : id));
    text = replaced(text, "_0: 8", "_" + std::to_string(index) + ": 8");
    text = replaced(text, kShippedSubject, source);
    if (text.starts_with("BA_ \"VFrameFormat\""))
      text = replaced(text, " 0;", " " + frame_format(can_) + ";");
    if (has_period() && text.starts_with("BA_ \"GenMsgCycleTime\""))
      text = replaced(text, " 10;", " " + std::to_string(can_.period.count()) + ";");
    return text;
  }

 private:
  bool has_period() const {
    return shipped_id_ == kShippedBase || shipped_id_ == kShippedBase + kSlidingOffset;
  }

  const CanSettings& can_;
  std::uint32_t shipped_id_;
};

}  // namespace

std::vector<std::string> source_names(const Settings& settings) {
  std::vector<std::string> sources;
  for (const auto& sensor : settings.sensors) sources.push_back("sensor " + sensor.setup.name);
  for (const auto& grasp : settings.grasps) sources.push_back("grasp " + grasp.name);
  for (std::string& source : sources) {
    std::replace_if(
        source.begin(), source.end(), [](char c) { return c == '"' || c == '\\' || c == '\n'; }, '\'');
  }
  return sources;
}

std::string dbc_text(const CanSettings& can, const std::vector<std::string>& sources) {
  const Instance estimate(can, kShippedBase);
  const Instance alert(can, kShippedBase + kAlertOffset);
  const Instance sliding(can, kShippedBase + kSlidingOffset);
  const Instance heartbeat(can, kShippedBase + kHeartbeatOffset);
  std::string text;
  for (const std::string& statement : statements(slipd_dbc)) {
    if (!can.sliding && sliding.about(statement)) continue;
    std::string made = heartbeat.of(statement, 0, "");
    for (std::size_t i = 0; i < sources.size(); ++i) {
      made += estimate.of(statement, i, sources[i]);
      made += alert.of(statement, i, sources[i]);
      made += sliding.of(statement, i, sources[i]);
    }
    text += made.empty() ? statement : made;
  }
  std::ostringstream base;
  base << "This one is of the running configuration on " << can.interface << ", base_id 0x" << std::hex
       << std::uppercase << can.base_id << '.';
  return replaced(text, "This file is for base_id 0x5A0; slipctl dbc prints the one of a running slipd.",
                  base.str());
}

}  // namespace slipd::can
