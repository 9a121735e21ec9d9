// can-check DBC CANDUMP ESTIMATES: decodes the messages in a log of candump -L by the DBC and compares them
// with the socket's estimates of the same frames (one JSON estimate a line). Prints what was compared. Exits
// with 1 and the first message that differs.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/dbc.hpp"

namespace {

using nlohmann::json;
using slipd::testing::DbcMessage;

struct Frame {
  double time_s = 0;
  std::uint32_t id = 0;
  bool extended = false, fd = false;
  std::array<std::uint8_t, 8> data{};
  std::string line;
};

// CRC-8 bit by bit, as the standard defines it, independent of slipd's table.
std::uint8_t crc_by_definition(const Frame& frame) {
  unsigned crc = 0xFF;
  const auto byte = [&](unsigned value) {
    crc ^= value & 0xFFU;
    for (int bit = 0; bit < 8; ++bit)
      crc = (crc & 0x80U) != 0 ? ((crc << 1) ^ 0x1DU) & 0xFFU : (crc << 1) & 0xFFU;
  };
  for (unsigned shift = 0; shift < 32; shift += 8) byte(frame.id >> shift);
  for (std::size_t i = 0; i + 1 < frame.data.size(); ++i) byte(frame.data[i]);
  return static_cast<std::uint8_t>(crc ^ 0xFF);
}

std::string text_of(const char* file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(std::string("cannot read ") + file);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<Frame> frames_of(const char* file) {
  const std::regex form(R"(\(([0-9.]+)\) \w+ ([0-9A-F]+)#(#[0-9A-F])?([0-9A-F]{16})( [TR])?)");
  std::vector<Frame> frames;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::smatch part;
    if (!std::regex_match(line, part, form)) continue;
    Frame& frame = frames.emplace_back();
    frame.time_s = std::stod(part[1]);
    frame.id = static_cast<std::uint32_t>(std::stoul(part[2], nullptr, 16));
    frame.extended = part[2].length() == 8;
    frame.fd = part[3].matched;
    frame.line = line;
    const std::string bytes = part[4];
    for (std::size_t i = 0; i < 8; ++i)
      frame.data[i] = static_cast<std::uint8_t>(std::stoul(bytes.substr(2 * i, 2), nullptr, 16));
  }
  return frames;
}

// Equal within one count. A value beyond the signal's range saturates.
bool same_number(const DbcMessage& message, const char* signal, const Frame& frame, const json& value) {
  const auto& defined = message.signals.at(signal);
  if (value.is_null()) return defined.raw(frame.data) == 0xFFFF;
  const double expected = std::min(value.get<double>(), 0xFFFE * defined.scale);
  return std::abs(defined.physical(frame.data) - expected) <= defined.scale;
}

bool same_word(const DbcMessage& message, const char* signal, const Frame& frame, const json& word) {
  const auto& defined = message.signals.at(signal);
  return json(defined.values.at(defined.raw(frame.data))) == word;
}

bool same(const DbcMessage& message, const Frame& frame, const json& estimate) {
  const char* const origin = estimate.at("simulated") ? "simulated" : "real";
  const bool common = same_word(message, "Alert", frame, estimate.at("alert")) &&
                      same_word(message, "Simulated", frame, origin) &&
                      same_number(message, "Gamma", frame, estimate.at("gamma"));
  if (message.name == "SLIP_ALERT_0") {
    return common && same_number(message, "GripIncrease", frame, estimate.at("grip_increase_n")) &&
           same_number(message, "TimeToSlip", frame, estimate.at("time_to_slip_ms"));
  }
  return common && same_word(message, "State", frame, estimate.at("state")) &&
         same_number(message, "Friction", frame, estimate.at("friction"));
}

// The socket's estimates by the low bits of seq, which are those that CAN carries.
class SocketEstimates {
 public:
  explicit SocketEstimates(const char* file) {
    std::ifstream lines(file);
    for (std::string line; std::getline(lines, line);) {
      const json estimate = json::parse(line, nullptr, false);
      if (estimate.is_object() && estimate.contains("seq"))
        estimates_.emplace(estimate["seq"].get<std::uint64_t>() % kTurn, estimate);
    }
  }

  // Whether the message agrees with an estimate between first and last, both modulo kTurn. Nothing: the
  // socket lacks one.
  std::optional<bool> agrees(const DbcMessage& message, const Frame& frame, std::uint64_t first,
                             std::uint64_t last) const {
    bool agreed = false;
    for (std::uint64_t at = first;; at = (at + 1) % kTurn) {
      const auto [begin, end] = estimates_.equal_range(at);
      if (begin == end) return std::nullopt;
      agreed =
          agreed || std::any_of(begin, end, [&](const auto& e) { return same(message, frame, e.second); });
      if (at == last) return agreed;
    }
  }

 private:
  static constexpr std::uint64_t kTurn = 4096;
  std::multimap<std::uint64_t, json> estimates_;
};

int check(char** files) {
  const auto messages = slipd::testing::read_dbc(text_of(files[1]));
  const SocketEstimates estimates(files[3]);
  std::size_t compared = 0, alerts = 0, unmatched = 0, stale_frames = 0;
  std::uint64_t sequence = 0;
  std::optional<Frame> alert;  // the last alert since the previous estimate
  std::map<std::string, std::size_t> seen;
  std::map<std::string, std::uint64_t> counters;
  std::vector<double> times_s;
  for (const Frame& frame : frames_of(files[2])) {
    const auto known = messages.find(frame.id);
    if (known == messages.end()) continue;
    const DbcMessage& message = known->second;
    if (message.extended != frame.extended) throw std::runtime_error("length of identifier: " + frame.line);
    if ((message.attributes.at("VFrameFormat") >= 14) != frame.fd)
      throw std::runtime_error("format: " + frame.line);
    if (message.signals.at("Crc8").raw(frame.data) != crc_by_definition(frame))
      throw std::runtime_error("checksum: " + frame.line);
    const std::uint64_t counter = message.signals.at("Counter").raw(frame.data);
    if (seen[message.name]++ > 0 && counter == counters[message.name])
      throw std::runtime_error("the counter stands still: " + frame.line);
    counters[message.name] = counter;
    if (message.name == "SLIP_ALERT_0") alert = frame;
    if (message.name != "SLIP_ESTIMATE_0") continue;
    times_s.push_back(frame.time_s);
    const std::uint64_t before = std::exchange(sequence, message.signals.at("Sequence").raw(frame.data));
    if (alert && times_s.size() > 1) {
      const auto agreed = estimates.agrees(messages.at(alert->id), *alert, before, sequence);
      if (agreed && !*agreed) throw std::runtime_error("alert and socket differ: " + alert->line);
      if (agreed) ++alerts;
    }
    alert.reset();
    const bool stale = message.signals.at("State").raw(frame.data) == 6;
    if (stale && message.signals.at("Gamma").raw(frame.data) == 0xFFFF) {
      ++stale_frames;
      continue;
    }
    const auto agreed = estimates.agrees(message, frame, sequence, sequence);
    if (agreed && !*agreed) throw std::runtime_error("CAN and socket differ: " + frame.line);
    ++(agreed ? compared : unmatched);
  }
  std::vector<double> gaps_ms;
  for (std::size_t i = 1; i < times_s.size(); ++i) gaps_ms.push_back((times_s[i] - times_s[i - 1]) * 1e3);
  std::sort(gaps_ms.begin(), gaps_ms.end());
  std::cout << "compared " << compared << ", alerts " << alerts << ", stale " << stale_frames
            << ", of frames before and after " << unmatched;
  for (const auto& [name, count] : seen) std::cout << ", " << name << ' ' << count;
  if (!gaps_ms.empty())
    std::cout << ", period p50 " << gaps_ms[gaps_ms.size() / 2] << " ms, p99 "
              << gaps_ms[gaps_ms.size() * 99 / 100] << " ms";
  std::cout << '\n';
  return compared >= 100 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc == 4) return check(argv);
    std::cerr << "can-check DBC CANDUMP ESTIMATES\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
