// slipctl calibrate with the real slipd and a program that pushes frames of a wrong scale.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <csignal>
#include <fstream>
#include <mutex>
#include <random>
#include <regex>
#include <thread>

#include "tests/support/awaiting.hpp"
#include "tests/support/daemon.hpp"
#include "tests/support/push_writer.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

constexpr std::size_t kTaxelsToCalibrate = 16;
constexpr double kGravityOfHundredGrams = 0.980665;

// A pad of 4 x 4 taxels that reads half of the normal force, a quarter of the pulls, and x and y exchanged.
class PadOfWrongScale {
 public:
  explicit PadOfWrongScale(std::filesystem::path socket)
      : thread_([this, path = std::move(socket)](const std::stop_token& stop) { send(path, stop); }) {}

  void carry(std::array<double, 3> force_n) {
    const std::scoped_lock held(mutex_);
    force_n_ = force_n;
  }

 private:
  static PushWriter connected(const std::filesystem::path& path) {
    PushWriter writer(path);
    if (writer.hello({.unit = push_layout::Unit::newton, .taxels = kTaxelsToCalibrate})) writer.answer();
    return writer;
  }

  void send(const std::filesystem::path& path, const std::stop_token& stop) {
    PushWriter writer = connected(path);
    std::mt19937_64 random(1);
    std::normal_distribution<float> noise(0, 0.001F);
    for (std::uint64_t sequence = 1; !stop.stop_requested(); ++sequence) {
      std::array<double, 3> read_n{};
      {
        const std::scoped_lock held(mutex_);
        read_n = {force_n_[1] / 4, force_n_[0] / 4, force_n_[2] / 2};
      }
      std::vector<float> frame(3 * kTaxelsToCalibrate);
      for (std::size_t i = 0; i < frame.size(); ++i)
        frame[i] = static_cast<float>(read_n[i % 3] / kTaxelsToCalibrate) + noise(random);
      if (!writer.push(frame, {.sequence = sequence})) writer = connected(path);  // slipd was reloaded
      std::this_thread::sleep_for(std::chrono::milliseconds(5));                  // the sensor's clock
    }
  }

  std::mutex mutex_;
  std::array<double, 3> force_n_{};
  std::jthread thread_;
};

class Calibrate : public ::testing::Test {
 protected:
  Calibrate()
      : daemon_(config_with(folder_, {{{"name", "left"},
                                       {"driver", "push"},
                                       {"layout", {{"grid", {4, 4}}, {"pitch_mm", 4}}},
                                       {"rate_hz", 200},
                                       {"stale_after_ms", 60'000},
                                       {"options", {{"zeroed", true}}}}}),
                real_drivers()),
        pad_(folder_.path() / "push" / "left") {
    daemon_.wait_for("status", [](const json& status) { return status["sensors"][0]["receiving"] == true; });
  }

  Ran calibrate(const std::string& sensor, const std::vector<std::string>& more) const {
    std::vector<std::string> command{(program_folder() / "slipctl").string(),
                                     "--socket",
                                     daemon_.socket().string(),
                                     "calibrate",
                                     sensor,
                                     "--normal",
                                     "200g",
                                     "--seconds",
                                     "1"};
    command.insert(command.end(), more.begin(), more.end());
    return run(command);
  }

  Ran step(const std::string& name, std::array<double, 3> force_n, const std::vector<std::string>& more) {
    pad_.carry(force_n);
    std::vector<std::string> words{"--step", name, "--file", folder_.file("steps.json").string()};
    words.insert(words.end(), more.begin(), more.end());
    return calibrate("left", words);
  }

  const TempFolder folder_;
  const Daemon daemon_;
  PadOfWrongScale pad_;
};

TEST_F(Calibrate, FindsTheFactorsOfAPadThatIsScaledWrongly) {
  const std::vector<std::string> pulls{"--shear", "100g"};
  EXPECT_EQ(step("zero", {0, 0, 0}, pulls).code, 0);
  EXPECT_EQ(step("normal", {0, 0, 2 * kGravityOfHundredGrams}, pulls).code, 0);
  EXPECT_EQ(step("shear-x", {kGravityOfHundredGrams, 0, 0.5}, pulls).code, 0);
  std::vector<std::string> in_json = pulls;
  in_json.emplace_back("--json");
  const Ran last = step("shear-y", {0, kGravityOfHundredGrams, 0.5}, in_json);
  ASSERT_EQ(last.code, 0) << last.errors;
  const json found = json::parse(last.output);
  // Five standard deviations of what is said, or a thousandth for float32.
  const auto expect = [&](const char* axis, double factor, const char* read_on) {
    EXPECT_NEAR(found[axis]["factor"].get<double>(), factor,
                std::max(5 * found[axis]["sigma"].get<double>(), 1e-3 * factor));
    EXPECT_LT(found[axis]["sigma"].get<double>(), 0.03 * factor);
    EXPECT_EQ(found[axis]["read_on"], read_on);
  };
  expect("normal", 2, "normal");
  expect("shear_x", 4, "y");
  expect("shear_y", 4, "x");
  EXPECT_EQ(found["gain"], nullptr) << "one factor is not enough";
  EXPECT_THAT(step("shear-y", {0, kGravityOfHundredGrams, 0.5}, pulls).output,
              HasSubstr("x is what now is y, y is what now is x"));
}

TEST_F(Calibrate, PrintsAScaleWithWhichThePadReadsTheWeight) {
  step("zero", {0, 0, 0}, {});
  const Ran last = step("normal", {0, 0, 2 * kGravityOfHundredGrams}, {});
  std::smatch line;
  ASSERT_TRUE(std::regex_search(last.output, line, std::regex("\"scale\": ([0-9.]+)"))) << last.output;
  json config = json::parse(std::ifstream(daemon_.config()));
  config["sensors"][0]["options"]["scale"] = std::stod(line[1]);
  std::ofstream(daemon_.config()) << config.dump();
  daemon_.program().signal(SIGHUP);
  RpcClient client = daemon_.client();
  await_true([&] {
    const json answer = client.call("frame", {{"sensor", "left"}});
    if (!answer.contains("result")) return false;  // the device is opened again
    double sum_pa = 0;
    for (const double each : answer["result"]["normal_pa"]) sum_pa += each;
    constexpr double kTaxelAreaM2 = 0.004 * 0.004;
    return std::fabs(sum_pa * kTaxelAreaM2 / (2 * kGravityOfHundredGrams) - 1) <
           0.05;  // the noise of one frame
  });
}

TEST_F(Calibrate, AsksAPersonForEachStep) {
  ::signal(SIGPIPE, SIG_IGN);  // a slipctl that ended early is a failure with its reason
  const std::string keys = folder_.file("keys").string();
  ASSERT_EQ(::mkfifo(keys.c_str(), 0600), 0);
  Program asking(
      folder_, "asking",
      {"/bin/sh", "-c",
       "exec '" + (program_folder() / "slipctl").string() + "' --socket '" + daemon_.socket().string() +
           "' calibrate left --normal 200g --seconds 1 < '" + keys + "'"});
  const UniqueFd enter(::open(keys.c_str(), O_WRONLY | O_CLOEXEC));
  ASSERT_EQ(::write(enter.get(), "\n", 1), 1) << asking.errors();
  await_true([&] { return asking.errors().find("Put the weight of 1.961 N") != std::string::npos; });
  ASSERT_EQ(::write(enter.get(), "\n", 1), 1) << asking.errors();
  await_true([&] { return asking.errors().find("step normal: ") != std::string::npos; });
  pad_.carry({0, 0, 2 * kGravityOfHundredGrams});
  ASSERT_EQ(::write(enter.get(), "\n", 1), 1) << asking.errors();
  EXPECT_EQ(asking.wait(), 0) << asking.errors();
  std::smatch scale;
  const std::string said = asking.output();
  ASSERT_TRUE(std::regex_search(said, scale, std::regex("\"scale\": ([0-9.]+)"))) << said;
  EXPECT_NEAR(std::stod(scale[1]), 2, 0.1) << "one frame of a hundred may be older than the weight";
}

TEST_F(Calibrate, SaysWhatIsWrong) {
  const Ran unknown = calibrate("right", {});
  EXPECT_EQ(unknown.code, 1);
  EXPECT_THAT(unknown.errors, HasSubstr("there is no sensor right; slipd has left"));
  step("zero", {0, 0, 0}, {});
  const Ran light = step("normal", {0, 0, 0}, {});
  EXPECT_EQ(light.code, 1);
  EXPECT_THAT(light.errors, HasSubstr("too little beside the noise"));
  const Ran silent = calibrate("left", {});
  EXPECT_EQ(silent.code, 1);
  EXPECT_THAT(silent.errors, HasSubstr("in scripts use --step and --file"));
  for (const std::vector<std::string>& wrong : std::vector<std::vector<std::string>>{
           {"--step", "zero"}, {"--step", "one", "--file", "x"}, {"--shear", "100"}})
    EXPECT_EQ(calibrate("left", wrong).code, 2);
}

}  // namespace
}  // namespace slipd::testing
