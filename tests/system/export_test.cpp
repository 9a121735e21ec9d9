// What was live is what a recording gives back: estimates of a subscriber at the full rate, and those of the
// flight recording of the same seconds, exported as CSV and as MCAP.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lz4frame.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <numbers>
#include <sstream>

#include "bridges/ros2/messages/cdr.hpp"
#include "bridges/ros2/messages/sensor_messages.hpp"
#include "core/recording/recorded_estimate.hpp"
#include "tests/support/csv.hpp"
#include "tests/support/daemon.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;

using Bytes = std::vector<std::uint8_t>;

std::string contents_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

template <class T>
T number_at(const std::string& bytes, std::size_t at) {
  T value{};
  std::memcpy(&value, bytes.substr(at, sizeof value).data(), sizeof value);
  return value;
}

// Calls `take` with the kind and the content of each record of MCAP.
template <class Take>
void each_record(const std::string& bytes, std::size_t from, std::size_t to, Take take) {
  while (from < to) {
    const auto size = number_at<std::uint64_t>(bytes, from + 1);
    take(static_cast<unsigned char>(bytes.at(from)), bytes.substr(from + 9, size));
    from += 9 + size;
  }
}

std::string unpacked(const std::string& chunk) {
  constexpr std::size_t kCompressionAt = 28;
  const std::size_t records_at =
      kCompressionAt + 4 + number_at<std::uint32_t>(chunk, kCompressionAt) + sizeof(std::uint64_t);
  std::string out(number_at<std::uint64_t>(chunk, 16), '\0');
  LZ4F_dctx* context = nullptr;
  LZ4F_createDecompressionContext(&context, LZ4F_VERSION);
  std::size_t got = out.size();
  std::size_t taken = chunk.size() - records_at;
  LZ4F_decompress(context, out.data(), &got, chunk.data() + records_at, &taken, nullptr);
  LZ4F_freeDecompressionContext(context);
  EXPECT_EQ(got, out.size());
  return out;
}

// The messages of each topic, in order.
std::map<std::string, std::vector<Bytes>> messages_of(const std::filesystem::path& file) {
  constexpr int kChannel = 4, kMessage = 5, kChunk = 6;
  constexpr std::size_t kMagicBytes = 8, kMessageHead = 22;
  std::map<std::uint16_t, std::string> topics;
  std::map<std::string, std::vector<Bytes>> messages;
  const auto take = [&](int kind, const std::string& record) {
    const auto channel = number_at<std::uint16_t>(record, 0);
    if (kind == kChannel) topics[channel] = record.substr(8, number_at<std::uint32_t>(record, 4));
    if (kind == kMessage) messages[topics[channel]].emplace_back(record.begin() + kMessageHead, record.end());
  };
  const std::string bytes = contents_of(file);
  each_record(bytes, kMagicBytes, bytes.size() - kMagicBytes, [&](int kind, const std::string& record) {
    if (kind != kChunk) return take(kind, record);
    const std::string records = unpacked(record);
    each_record(records, 0, records.size(), take);
  });
  return messages;
}

// The rows of a CSV file by the number of their frame: texts by column.
std::map<std::uint64_t, std::map<std::string, std::string>> rows_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  const auto columns = row_fields(line);
  std::map<std::uint64_t, std::map<std::string, std::string>> rows;
  while (std::getline(in, line)) {
    const auto fields = row_fields(line);
    std::map<std::string, std::string> row;
    for (std::size_t i = 0; i < columns.size(); ++i) row[columns[i]] = fields.at(i);
    rows[std::stoull(row.at("seq"))] = row;
  }
  return rows;
}

// A member of a live estimate (docs/socket.md) for an entry of a recorded one.
struct LiveName {
  std::string key;
  double factor = 1;  // live over recorded
};
LiveName live_name_of(const std::string& key) {
  if (key == "torque_nm") return {"torque_nmm", 1e3};
  if (key == "torque_sigma_nm") return {"torque_sigma_nmm", 1e3};
  if (key == "turned_rad") return {"turned_deg", 180 / std::numbers::pi};
  if (key == "turned_sigma_rad") return {"turned_sigma_deg", 180 / std::numbers::pi};
  if (key == "radius_m") return {"radius_mm", 1e3};
  if (key == "time_to_slip_s") return {"time_to_slip_ms", 1e3};
  if (key == "sliding_for_s") return {"sliding_for_ms", 1e3};
  return {key};
}

json live_value(const json& live, const std::string& key) {
  if (key == "center_x_m" || key == "center_y_m") {
    const json& center = live.at("center_mm");
    return center.is_null() ? center : center.at(key == "center_x_m" ? 0 : 1);
  }
  return live.at(live_name_of(key).key);
}

double factor_of(const std::string& key) {
  return key == "center_x_m" || key == "center_y_m" ? 1e3 : live_name_of(key).factor;
}

// The number that slipd printed, and nothing but it.
void compare_row(const std::map<std::string, std::string>& row, const json& live) {
  for (const RecordedEntry& entry : kRecordedEntries) {
    const std::string key(entry.key);
    const std::string& field = row.at(key);
    const json value = live_value(live, key);
    if (entry.code != nullptr) {
      // The socket has null where there is no alert.
      EXPECT_EQ(field, key == "alert_cause" && value.is_null() ? "none"
                       : value.is_null()                       ? ""
                                                               : value.get<std::string>())
          << key;
    } else if (value.is_null()) {
      EXPECT_EQ(field, "") << key;
    } else {
      EXPECT_EQ(std::stod(field) * factor_of(key), value.get<double>()) << key;
    }
  }
}

// The message that slipd-ros2 makes of this row. Only the stamp is left to the recording.
ros2::SlipEstimate message_of(const std::map<std::string, std::string>& row, const json& live,
                              const std::array<std::vector<std::string>, 3>& names) {
  const auto number = [&](const char* key) {
    return row.at(key).empty() ? std::numeric_limits<double>::quiet_NaN() : std::stod(row.at(key));
  };
  const auto code = [](const std::vector<std::string>& all, const std::string& name) {
    return static_cast<std::uint8_t>(std::find(all.begin(), all.end(), name) - all.begin());
  };
  ros2::SlipEstimate message;
  message.header.frame_id = message.name = live.at("sensor").get<std::string>();
  message.state = code(names[0], live.at("state"));
  message.alert = code(names[1], live.at("alert"));
  if (!live.at("sliding").is_null()) message.sliding = code(names[2], live.at("sliding"));
  message.simulated = live.at("simulated");
  message.seq = live.at("seq");
  message.age = 0;
  message.margin = number("gamma");
  message.margin_sigma = number("sigma");
  message.margin_low = number("gamma_low");
  message.friction = number("friction");
  message.friction_sigma = number("friction_sigma");
  message.normal_force = number("normal_n");
  message.shear_force = number("shear_n");
  message.shear_force_x = number("shear_x_n");
  message.shear_force_y = number("shear_y_n");
  message.torque = number("torque_nm");
  message.torque_sigma = number("torque_sigma_nm");
  message.center_x = number("center_x_m");
  message.center_y = number("center_y_m");
  message.radius = number("radius_m");
  message.time_to_slip = number("time_to_slip_s");
  message.grip_increase = number("grip_increase_n");
  message.grip_increase_sigma = number("grip_increase_sigma_n");
  message.sliding_for = number("sliding_for_s");
  return message;
}

// Bytes of a message with the stamp of another one.
template <class T>
Bytes bytes_of(const T& message, const Bytes& stamped) {
  constexpr std::size_t kStampAt = 4, kStampBytes = 8;  // behind the head of CDR
  Bytes bytes;
  ros2::encode(message, bytes);
  if constexpr (!std::is_same_v<T, ros2::Float32>)
    std::copy_n(stamped.begin() + kStampAt, kStampBytes, bytes.begin() + kStampAt);
  return bytes;
}

TEST(Export, GivesTheVeryNumbersThatWereLive) {
  const std::array<std::vector<std::string>, 3> names{
      {{"ok", "no_contact", "learning", "out_of_model", "no_shear", "unzeroed", "stale", "fault"},
       {"none", "warn", "slip", "unknown"},
       {"none", "disturbed", "translation", "rotation"}}};
  const TempFolder folder, state;
  Daemon daemon(config_with(folder,
                            json::array({{{"name", "left"},
                                          {"driver", "sim"},
                                          {"rate_hz", 200},
                                          {"layout", {{"grid", {8, 8}}, {"pitch_mm", 1.5}}},
                                          {"skin", {{"radius_mm", 10}}}}}),
                            {{"recorder", {{"seconds", 1}}}}),
                real_drivers(), {{"STATE_DIRECTORY", state.path().string()}});
  RpcClient subscriber(daemon.socket());
  subscriber.result("subscribe", {{"sensors", json::array({"left"})}, {"events", json::array({"estimate"})}});
  std::map<std::uint64_t, json> live;
  std::string file;
  while (file.empty()) {  // until the recording of the first slip is written, a second after it
    const json estimate = subscriber.notification().at("params");
    live.emplace(estimate.at("seq"), estimate);  // its first; another one says that no frame followed in time
    if (live.size() % 50 != 0) continue;
    const json last = daemon.client().result("status")["recorder"]["last"];
    if (!last.empty() && last[0]["file"].is_string()) file = last[0]["file"];
  }
  ASSERT_THAT(file, ::testing::EndsWith("-slip.rec"));
  const Ran ran = run({(program_folder() / "slipctl").string(), "export", file, "--csv", folder.file("s.csv"),
                       "--mcap", folder.file("s.mcap")});
  ASSERT_EQ(ran.code, 0) << ran.errors;
  EXPECT_EQ(ran.errors, "");

  const auto rows = rows_of(folder.file("s.csv"));
  auto messages = messages_of(folder.file("s.mcap"));
  const auto& wrenches = messages.at("/slipd/left/wrench");
  const auto& estimates = messages.at("/slipd/left/estimate");
  const auto& margins = messages.at("/slipd/left/margin");
  const auto& lower = messages.at("/slipd/left/margin_low");
  ASSERT_EQ(wrenches.size(), rows.size());
  std::size_t frame = 0, estimated = 0, compared = 0;
  std::map<std::string, std::size_t> known;
  for (const auto& [sequence, row] : rows) {
    SCOPED_TRACE(sequence);
    const std::size_t at = frame++;
    if (row.at("state").empty()) continue;  // skipped, or the last frames
    const std::size_t its = estimated++;
    const auto found = live.find(sequence);
    if (found == live.end()) continue;  // it came before the subscription
    ++compared;
    compare_row(row, found->second);
    const auto message = message_of(row, found->second, names);
    EXPECT_EQ(estimates.at(its), bytes_of(message, estimates.at(its)));
    EXPECT_EQ(wrenches.at(at), bytes_of(wrench_of(message), wrenches.at(at)));
    EXPECT_EQ(margins.at(its), bytes_of(margin_of(message), {}));
    EXPECT_EQ(lower.at(its), bytes_of(margin_low_of(message), {}));
    for (const auto& [key, field] : row) known[key] += field.empty() ? 0 : 1;
    if (::testing::Test::HasFailure()) return;
  }
  EXPECT_EQ(estimates.size(), estimated);
  EXPECT_GT(compared, 0U);
  for (const char* key : {"gamma", "gamma_low", "friction_sigma", "grip_increase_n", "center_x_m", "radius_m",
                          "shear_x_n", "sliding", "method", "health"})
    EXPECT_GT(known[key], 0U) << key << " was compared";
}

}  // namespace
}  // namespace slipd::testing
