// Frames on the socket of the real daemon: their encodings agree, and the last one of a sensor that is gone
// says so.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <string>
#include <vector>

#include "tests/support/daemon.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;

// The sensor ends once the file is there, and its last frame is all that there is from then on.
TEST(EndedSensor, ItsFrameSaysTheStateAndHowOldItIs) {
  const TempFolder folder;
  const auto end = folder.file("end");
  const json sensor = trial_sensor("left", {{"behaviour", "end"}, {"well_until", end.string()}},
                                   {{"stale_after_ms", 60'000}});
  Daemon daemon(config_with(folder, json::array({sensor})), trial_drivers());
  const auto state_is = [](const char* state) {
    return [state](const json& r) { return r["sensors"][0]["state"] == state; };
  };
  daemon.wait_for("gamma", state_is("ok"));
  const json encodings = {nullptr, "base64", "bytes"};
  auto client = daemon.client();
  const auto frame_in = [&](const json& encoding) {
    json params{{"sensor", "left"}};
    if (!encoding.is_null()) params["encoding"] = encoding;
    return client.result("frame", params);
  };
  for (const json& encoding : encodings) {
    EXPECT_EQ(frame_in(encoding)["state"], "ok") << encoding;
    EXPECT_GE(frame_in(encoding)["age_ms"].get<double>(), 0) << encoding;
  }
  folder.write("end", "");
  daemon.wait_for("gamma", state_is("stale"));
  for (const json& encoding : encodings) {
    const json first = frame_in(encoding), second = frame_in(encoding);
    EXPECT_EQ(first["state"], "stale") << encoding;
    EXPECT_EQ(first["seq"], second["seq"]) << encoding;
    EXPECT_GT(second["age_ms"].get<double>(), first["age_ms"].get<double>()) << encoding;
    const double sampled_s = 1e-9 * second["time_ns"].get<double>(),
                 age_s = 1e-3 * second["age_ms"].get<double>();
    EXPECT_NEAR(sampled_s + age_s, static_cast<double>(std::time(nullptr)), 60) << encoding;
  }
}

// RFC 4648, section 4.
std::string bytes_of_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int held = 0;
  for (const char digit : text.substr(0, text.find('='))) {
    bits = (bits << 6) | static_cast<unsigned>(digits.find(digit));
    held += 6;
    if (held >= 8) bytes.push_back(static_cast<char>(bits >> (held -= 8)));
  }
  return bytes;
}

std::vector<float> floats_of_base64(const std::string& text) {
  const std::string bytes = bytes_of_base64(text);
  std::vector<float> values(bytes.size() / sizeof(float));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(float));
  return values;
}

// No frame comes between two requests: its sensor has fallen silent.
class SocketOfASilentSensor : public ::testing::Test {
 protected:
  static constexpr int kFrames = 20;

  void SetUp() override {
    daemon_.wait_for("status", [](const json& r) { return r["sensors"][0]["received"] >= kFrames; });
  }
  static json config(const TempFolder& folder) {
    const json sensor = trial_sensor("left", {{"behaviour", "silent"}, {"after", kFrames}},
                                     {{"stale_after_ms", 60'000},  // never: its last frame stays a good one
                                      {"layout", {{"grid", {20, 20}}, {"pitch_mm", 0.72}}}});
    return config_with(folder, json::array({sensor}));
  }

  TempFolder folder_;
  Daemon daemon_{config(folder_), trial_drivers()};
};

TEST_F(SocketOfASilentSensor, AFrameInBase64IsTheFrameInDigits) {
  auto client = daemon_.client();
  const json digits = client.result("frame", {{"sensor", "left"}});
  const json base64 = client.result("frame", {{"sensor", "left"}, {"encoding", "base64"}});
  ASSERT_EQ(digits["seq"], base64["seq"]);
  for (const char* column : {"normal_pa", "shear_x_pa", "shear_y_pa"})
    EXPECT_EQ(floats_of_base64(base64[column]), digits[column].get<std::vector<float>>()) << column;
  EXPECT_FALSE(base64.contains("x_mm"));
  EXPECT_EQ(client.call("frame", {{"sensor", "left"}, {"encoding", "hex"}})["error"]["code"], -32602);
}

TEST_F(SocketOfASilentSensor, AFrameInBytesIsTheFrameToWithinHalfAStep) {
  auto client = daemon_.client();
  const json digits = client.result("frame", {{"sensor", "left"}});
  const json bytes = client.result("frame", {{"sensor", "left"}, {"encoding", "bytes"}});
  ASSERT_EQ(digits["seq"], bytes["seq"]);
  const std::string values = bytes_of_base64(bytes["values"]);
  const auto normal = digits["normal_pa"].get<std::vector<float>>();
  const auto shear_y = digits["shear_y_pa"].get<std::vector<float>>();
  ASSERT_EQ(values.size(), 3 * normal.size());
  const double peak = bytes["peak_pa"], peak_shear = bytes["peak_shear_pa"];
  for (std::size_t i = 0; i < normal.size(); ++i) {
    const auto pressure = static_cast<unsigned char>(values[i]);
    const auto shear = static_cast<signed char>(values[2 * normal.size() + i]);
    EXPECT_NEAR(pressure / 255. * peak, std::max(0.F, normal[i]), peak / 509);
    EXPECT_NEAR(shear / 127. * peak_shear, shear_y[i], peak_shear / 253);
  }
}

}  // namespace
}  // namespace slipd::testing
