#include "tools/slipctl/fleet_state.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <nlohmann/json.hpp>
#include <tuple>

#include "tools/slipctl/number_text.hpp"
#include "tools/slipctl/palette.hpp"
#include "tools/slipctl/table.hpp"

namespace slipctl {
namespace {

// Names come from the network: a control character would reach the terminal.
std::string printable(std::string text) {
  constexpr unsigned char kDelete = 0x7f, kC1Lead = 0xc2, kC1End = 0xa0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 0);
    if (byte == kC1Lead && next < kC1End)
      text.replace(i, 2, "?");
    else if (byte < ' ' || byte == kDelete)
      text[i] = '?';
  }
  return text;
}

std::string text_at(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? printable(found->get<std::string>()) : std::string();
}

template <typename Number>
std::optional<Number> number_at(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  return found->get<Number>();
}

bool flag_at(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && *found == true;
}

std::string count_text(std::optional<std::int64_t> count) {
  return count ? std::to_string(*count) : "–";
}

std::string time_text(std::optional<std::int64_t> realtime_ns) {
  if (!realtime_ns) return "–";
  constexpr std::int64_t kNsPerSecond = 1'000'000'000;
  const std::time_t seconds = *realtime_ns / kNsPerSecond;
  std::tm parts{};
  std::array<char, 32> text{};
  if (localtime_r(&seconds, &parts) == nullptr) return "–";
  return {text.data(), std::strftime(text.data(), text.size(), "%F %T", &parts)};
}

bool offline(const FleetLine& line) {
  return line.status != "online";
}

std::string state_text(const FleetLine& line) {
  if (offline(line)) return line.status;
  return line.state + (line.state_of.empty() || line.state == "ok" ? "" : " (" + line.state_of + ")");
}

std::string margin_text(const FleetLine& line) {
  return fixed(line.gamma, 2) + (line.gamma ? " (" + line.gamma_of + ")" : "");
}

std::string since_text(const FleetLine& line) {
  return offline(line) ? time_text(line.offline_since_ns) : "";
}

std::string or_dash(const std::string& text) {
  return text.empty() ? "–" : text;
}

constexpr std::array<const char*, 7> kHeadings{"gripper",  "state",   "margin",       "alert",
                                               "alerts/h", "version", "offline since"};

std::vector<std::string> cells_of(const FleetLine& line) {
  return {
      line.gripper,
      state_text(line),
      margin_text(line),
      or_dash(line.alert),
      count_text(line.alerts_last_hour) +
          (line.alerts_dropped.value_or(0) > 0 ? ", " + count_text(line.alerts_dropped) + " dropped" : ""),
      or_dash(line.version) + (line.simulated ? " simulated" : ""),
      since_text(line)};
}

Style style_of(const FleetLine& line, std::size_t column) {
  constexpr std::size_t kState = 1, kMargin = 2, kAlert = 3, kVersion = 5;
  if (column == kState) {
    if (offline(line)) return {kRed, std::nullopt, true};
    return {line.state == "ok" || line.state == "no_contact" ? kGreen : kYellow, std::nullopt, false};
  }
  if (column == kMargin) return {margin_colour(line.gamma), std::nullopt, true};
  if (column == kAlert) return alert_style(line.alert);
  if (column == kVersion && line.simulated) return {kViolet, std::nullopt, false};
  return {};
}

// "3 grippers, 1 offline, 1 slip, 1 warn"
std::string totals(const FleetState& state) {
  const auto count = [&](auto holds) {
    return std::count_if(state.lines.begin(), state.lines.end(),
                         [&](const auto& each) { return holds(each.second); });
  };
  std::string text = std::to_string(state.lines.size()) + " grippers";
  if (const auto away = count(offline); away > 0) text += ", " + std::to_string(away) + " offline";
  for (const char* alert : {"slip", "warn"}) {
    const auto alerted = count([&](const FleetLine& line) { return line.alert == alert; });
    if (alerted > 0) text += ", " + std::to_string(alerted) + " " + alert;
  }
  return text;
}

}  // namespace

std::string take_fleet_line(FleetState& state, const std::string& text) {
  const nlohmann::json line = nlohmann::json::parse(text, nullptr, false);
  if (!line.is_object()) return {};
  if (line.contains("broker")) {
    state.broker = text_at(line, "broker");
    state.trouble = text_at(line, "trouble");
    state.connected = flag_at(line, "connected");
    if (!state.connected) state.lines.clear();
    return {};
  }
  std::string gripper = text_at(line, "gripper");
  if (gripper.empty()) return {};
  if (text_at(line, "status") == "removed") {
    state.lines.erase(gripper);
    return gripper;
  }
  state.lines[gripper] = {gripper,
                          text_at(line, "status"),
                          text_at(line, "state"),
                          text_at(line, "state_of"),
                          number_at<double>(line, "gamma"),
                          text_at(line, "gamma_of"),
                          text_at(line, "alert"),
                          number_at<std::int64_t>(line, "alerts_last_hour"),
                          number_at<std::int64_t>(line, "alerts_dropped"),
                          text_at(line, "version"),
                          flag_at(line, "simulated"),
                          number_at<std::int64_t>(line, "offline_since_ns")};
  return gripper;
}

std::vector<const FleetLine*> by_urgency(const FleetState& state) {
  const auto key = [](const FleetLine* line) {
    const bool calm = line->state == "ok" || line->state == "no_contact";
    const int rank = line->alert == "slip"   ? 0
                     : offline(*line)        ? 1
                     : line->alert == "warn" ? 2
                     : !calm                 ? 3
                                             : 4;
    constexpr double kAboveEveryMargin = 2;
    return std::tuple(rank, line->gamma.value_or(kAboveEveryMargin), line->gripper);
  };
  std::vector<const FleetLine*> lines;
  for (const auto& [name, line] : state.lines) lines.push_back(&line);
  std::sort(lines.begin(), lines.end(),
            [&](const FleetLine* a, const FleetLine* b) { return key(a) < key(b); });
  return lines;
}

Canvas draw_fleet(const FleetState& state, int columns, int rows) {
  Canvas canvas(columns, rows);
  constexpr Style kHeader{kWhite, Rgb{40, 60, 90}, true};
  for (int column = 0; column < columns; ++column) canvas.put(column, 0, U' ', kHeader);
  canvas.text(1, 0, state.connected ? totals(state) + "  " + state.broker : "no broker: " + state.trouble,
              kHeader, columns - 10);
  canvas.text(columns - 8, 0, "q quits", kHeader);
  const std::vector<const FleetLine*> lines = by_urgency(state);
  const auto shown = std::min(lines.size(), static_cast<std::size_t>(std::max(0, rows - 3)));
  std::vector<std::vector<std::string>> cells{{kHeadings.begin(), kHeadings.end()}};
  for (std::size_t i = 0; i < shown; ++i) cells.push_back(cells_of(*lines[i]));
  int left = 0;
  for (std::size_t column = 0; column < kHeadings.size(); ++column) {
    std::size_t width = 0;
    for (const auto& row : cells) width = std::max(width, characters(row[column]));
    for (std::size_t row = 0; row < cells.size(); ++row)
      canvas.text(left, static_cast<int>(row) + 1, cells[row][column],
                  row == 0 ? kFaint : style_of(*lines[row - 1], column));
    left += static_cast<int>(width) + 2;
  }
  if (shown < lines.size())
    canvas.text(0, rows - 1, "and " + std::to_string(lines.size() - shown) + " more", kFaint);
  return canvas;
}

std::string fleet_table(const FleetState& state) {
  std::vector<std::vector<std::string>> rows{{kHeadings.begin(), kHeadings.end()}};
  for (const auto& [name, line] : state.lines) rows.push_back(cells_of(line));
  return table(rows);
}

std::string fleet_text(const FleetLine& line) {
  const std::string since = since_text(line);
  return line.gripper + "  " + state_text(line) + "  margin " + margin_text(line) + "  alert " +
         or_dash(line.alert) + "  alerts/h " + count_text(line.alerts_last_hour) + "  slipd " +
         or_dash(line.version) + (line.simulated ? "  simulated" : "") +
         (since.empty() ? "" : "  offline since " + since);
}

}  // namespace slipctl
