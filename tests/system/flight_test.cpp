// The flight recorder in the real daemon: on an alert, on request, and on a disk that takes nothing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <fstream>

#include "core/recording/recording.hpp"
#include "tests/support/daemon.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;

constexpr double kSeconds = 0.3;
constexpr double kRateHz = 200;

json watched(const TempFolder& folder, const json& options, const json& recorder) {
  return config_with(
      folder,
      json::array({{{"name", "left"}, {"driver", "trial"}, {"rate_hz", kRateHz}, {"options", options}}}),
      {{"recorder", recorder}});
}

std::vector<std::filesystem::path> recordings(const TempFolder& state) {
  std::vector<std::filesystem::path> found;
  for (const auto& item : std::filesystem::directory_iterator(state.file("recordings")))
    found.push_back(item.path());
  return found;
}

TEST(Flight, KeepsTheSecondsAroundARequest) {
  const TempFolder folder;
  const TempFolder state;
  Daemon daemon(watched(folder, json::object(), {{"seconds", kSeconds}}), trial_drivers(),
                {{"STATE_DIRECTORY", state.path().string()}});
  daemon.wait_for("status",
                  [](const json& s) { return s["sensors"][0]["received"] >= 2 * kSeconds * kRateHz; });
  EXPECT_EQ(daemon.client().result("flight")["sensors"], json({"left"}));
  const json status = daemon.wait_for("status", [](const json& s) { return s["recorder"]["kept"] == 1; });
  const auto files = recordings(state);
  ASSERT_EQ(files.size(), 1U);
  EXPECT_EQ(status["recorder"]["last"][0]["file"], files.front().string());
  EXPECT_EQ(status["recorder"]["last"][0]["recording"], 1);
  RecordingReader reader(files.front());
  EXPECT_EQ(reader.header().sensor, "left");
  const std::size_t taxels = reader.header().layout.size();
  std::vector<float> memory(3 * taxels);
  FrameSlot slot;
  slot.normal_pa = std::span(memory).subspan(0, taxels);
  slot.shear_x_pa = std::span(memory).subspan(taxels, taxels);
  slot.shear_y_pa = std::span(memory).subspan(2 * taxels, taxels);
  std::size_t frames = 0;
  std::size_t ok_frames = 0, other_frames = 0;  // frames in state ok, and in any other state
  std::size_t last_frames = 0;                  // after the last with an estimate
  std::optional<std::uint64_t> last;
  std::optional<RecordedEstimate> estimate;
  while (reader.next(slot, &estimate) == RecordingReader::Status::frame) {
    EXPECT_TRUE(!last || slot.sequence > *last);
    last = slot.sequence;
    ++frames;
    last_frames = estimate ? 0 : last_frames + 1;
    if (estimate && estimate->state != 0) ++other_frames;
    if (!estimate || estimate->state != 0) continue;
    EXPECT_NEAR(estimate->gamma, 0.5, 0.1);
    ++ok_frames;
  }
  EXPECT_TRUE(reader.fault().empty()) << reader.fault();
  EXPECT_LE(static_cast<double>(frames), 2 * kSeconds * kRateHz + 16);
  // Each estimated frame has its estimate in the recording; each frame without an estimate was skipped. A
  // recording may end before the estimates of its last frames have come.
  const json sensor = daemon.client().result("status")["sensors"][0];
  EXPECT_GT(ok_frames, 0U);
  EXPECT_LE(frames - last_frames, ok_frames + sensor["skipped"].get<std::uint64_t>() + other_frames);
}

TEST(Flight, KeepsWhatLedToASlip) {
  const TempFolder folder;
  const TempFolder state;
  Daemon daemon(watched(folder, {{"gamma", 0.05}}, {{"seconds", 0.05}}), trial_drivers(),
                {{"STATE_DIRECTORY", state.path().string()}});
  daemon.wait_for("status", [](const json& s) { return s["recorder"]["kept"] == 1; });
  EXPECT_THAT(recordings(state).front().filename().string(), ::testing::EndsWith("-slip.rec"));
}

TEST(Flight, ADiskThatTakesNothingLosesOnlyTheRecording) {
  const TempFolder folder;
  Daemon daemon(watched(folder, json::object(), {{"seconds", 0.05}}), trial_drivers(),
                {{"STATE_DIRECTORY", "/dev/full"}});
  daemon.wait_for("gamma", [](const json& r) { return r["sensors"][0]["state"] == "ok"; });
  daemon.client().result("flight");
  const json status = daemon.wait_for("status", [](const json& s) { return s["recorder"]["failed"] == 1; });
  EXPECT_THAT(status["recorder"]["last"][0]["trouble"].get<std::string>(),
              ::testing::HasSubstr("could not be kept"));
  EXPECT_THAT(daemon.program().errors(), ::testing::HasSubstr("could not be kept"));
  EXPECT_THAT(daemon.client().result("metrics").get<std::string>(),
              ::testing::HasSubstr("slipd_flight_recordings_failed_total 1\n"));
  const Ran ran =
      run({(program_folder() / "slipctl").string(), "--socket", daemon.socket().string(), "flight"});
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.errors, ::testing::HasSubstr("could not be kept"));
  daemon.wait_for("gamma", [](const json& r) { return r["sensors"][0]["state"] == "ok"; });
}

// A slip is being written to a disk that stalls while the file "stalled" is in the folder.
class StalledDisk : public ::testing::Test {
 protected:
  void SetUp() override {
    if (sanitized()) GTEST_SKIP() << "the sanitizer must be the first library";
    daemon_.emplace(config({{"gamma", 0.05}}), trial_drivers(),
                    Program::Environment{
                        {"STATE_DIRECTORY", state_.path().string()},
                        {"LD_PRELOAD", std::string(SLIPD_BINARY_DIR) + "/test-bin/libslipd-stalled-disk.so"},
                        {"SLIPD_STALLED_DISK", stalled_.string()}});
    await_recording(".part");
  }
  json config(const json& options) const { return watched(folder_, options, {{"seconds", 0.05}}); }
  void await_recording(const std::string& extension) const {
    daemon_->wait_for("version", [&](const json&) {
      const auto there = [&](const auto& file) { return file.extension() == extension; };
      return std::filesystem::exists(state_.file("recordings")) &&
             std::ranges::any_of(recordings(state_), there);
    });
  }
  const TempFolder folder_;
  const TempFolder state_;
  const std::filesystem::path stalled_ = folder_.write("stalled", "");
  std::optional<Daemon> daemon_;
};

TEST_F(StalledDisk, DoesNotKeepAReloadFromItsEndAndCostsNoRecording) {
  std::ofstream(daemon_->config()) << config({{"gamma", 0.5}}).dump();
  daemon_->program().signal(SIGHUP);
  daemon_->wait_for_log("reload: the new configuration is in force");
  daemon_->wait_for("gamma", [](const json& r) { return r["sensors"][0]["state"] == "ok"; });
  EXPECT_THAT(daemon_->program().errors(),
              ::testing::HasSubstr("the flight recorder of the old configuration does not end"));
  std::filesystem::remove(stalled_);
  await_recording(".rec");
  EXPECT_EQ(daemon_->stop(), 0);
}

TEST_F(StalledDisk, DoesNotKeepAStopFromItsEnd) {
  EXPECT_EQ(daemon_->stop(), 0);
  EXPECT_THAT(daemon_->program().errors(), ::testing::HasSubstr("the flight recorder does not end"));
}

TEST(Flight, IsOffUnlessAskedFor) {
  const TempFolder folder;
  Daemon daemon(watched(folder, json::object(), json::object()), trial_drivers());
  EXPECT_EQ(daemon.client().result("status")["recorder"], "off");
  EXPECT_EQ(daemon.client().call("flight")["error"]["code"], -32003);
}

}  // namespace
}  // namespace slipd::testing
