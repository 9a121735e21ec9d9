// A sensor that does not zero itself, with the real daemon: it gives no margin before its bias is known,
// takes no bias under load, gives the same margin after a restart in mid-grasp, and refuses a damaged file
// or another sensor's.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "tests/support/daemon.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// A sensor whose offsets are three times the pressure of its contact.
json sensor(const json& cycle, const json& options = json::object()) {
  json all{{"speed", 0}, {"zeroed", false}, {"zero_spread_kpa", 100}, {"noise", 0.002}, {"cycle", cycle}};
  all.merge_patch(options);
  return {{"name", "left"},
          {"driver", "sim"},
          {"stale_after_ms", 60'000},
          {"friction", 0.5},
          {"layout", {{"grid", {24, 24}}, {"pitch_mm", 0.6}}},
          {"options", all}};
}

constexpr int kForEverMs = 86'400'000;
const json kFree = {{{"ms", kForEverMs}, {"normal_n", 0}, {"shear_n", 0}, {"friction", 0.5}}};
const json kHeld = {{{"ms", 1}, {"normal_n", 2}, {"shear_n", 0}, {"friction", 0.5}},
                    {{"ms", 50}, {"load", {0, 0.5}}},
                    {{"ms", kForEverMs}}};

class BiasTest : public ::testing::Test {
 protected:
  Daemon start(const json& cycle, const json& options = json::object()) const {
    return {config_with(folder_, json::array({sensor(cycle, options)})),
            real_drivers(),
            {{"STATE_DIRECTORY", folder_.file("state").string()}}};
  }
  static json zero_of(const Daemon& daemon) { return daemon.client().result("status")["sensors"][0]["zero"]; }
  static json await(const Daemon& daemon, const char* state) {
    return daemon.wait_for(
        "gamma", [&](const json& result) { return result["sensors"][0]["state"] == state; })["sensors"][0];
  }
  std::filesystem::path kept() const {
    for (const auto& file : std::filesystem::directory_iterator(folder_.file("state") / "zero")) return file;
    return {};
  }
  const TempFolder folder_;
};

TEST_F(BiasTest, IsTakenOnRequestAndHoldsThroughARestartInMidGrasp) {
  {
    const Daemon daemon = start(kFree);
    const json before = await(daemon, "unzeroed");
    EXPECT_EQ(before["gamma"], nullptr);
    EXPECT_EQ(before["normal_n"], nullptr);
    EXPECT_EQ(zero_of(daemon)["origin"], "none");
    EXPECT_EQ(zero_of(daemon)["trouble"],
              "its zero is not known yet: unload it, then run slipctl rebias left");
    const json taken = daemon.client().result("rebias", {{"sensor", "left"}});
    EXPECT_EQ(taken["sensor"], "left");
    EXPECT_EQ(taken["origin"], "command");
    EXPECT_EQ(taken["trouble"], nullptr);
    EXPECT_NEAR(taken["noise_normal_pa"].get<double>(), 200 / std::sqrt(3), 5) << "uniform, 0.2 % of 100 kPa";
    await(daemon, "no_contact");
    EXPECT_EQ(zero_of(daemon)["trouble"], nullptr);
    EXPECT_EQ(std::filesystem::status(kept()).permissions(), std::filesystem::perms(0640));
  }
  const Daemon daemon = start(kHeld);
  const json held = daemon.wait_for("gamma", [](const json& result) {
    const json& left = result["sensors"][0];
    EXPECT_NE(left["state"], "unzeroed");
    return left["state"] == "ok" && left["normal_n"].is_number() && left["truth"]["gamma"].is_number() &&
           std::fabs(left["gamma"].get<double>() - left["truth"]["gamma"].get<double>()) < 0.02 &&
           std::fabs(left["truth"]["gamma"].get<double>() - 0.5) < 1e-3;
  })["sensors"][0];
  EXPECT_NEAR(held["normal_n"].get<double>(), 2, 0.05);
  const json zero = zero_of(daemon);
  EXPECT_EQ(zero["restored"], true);
  EXPECT_EQ(zero["free"], false);
  EXPECT_GE(zero["taken_s_ago"], zero["confirmed_s_ago"]);
}

TEST_F(BiasTest, CanBeRequestedOnTheCommandLine) {
  const Daemon daemon = start(kFree);
  const std::string slipctl = (program_folder() / "slipctl").string();
  const Ran ran = run({slipctl, "--socket", daemon.socket().string(), "rebias", "left"});
  EXPECT_EQ(ran.code, 0) << ran.errors;
  EXPECT_THAT(ran.output, StartsWith("left: zeroed, noise 11"));
  const Ran again =
      run({slipctl, "--socket", daemon.socket().string(), "--json", "rebias", "--force", "left"});
  EXPECT_THAT(again.output, StartsWith(R"({"origin":"command","restored":false,)"))
      << "in the daemon's order";
  const Ran missing = run({slipctl, "--socket", daemon.socket().string(), "rebias", "right"});
  EXPECT_EQ(missing.code, 1);
  EXPECT_THAT(daemon.client().result("metrics").get<std::string>(),
              HasSubstr("slipd_zeroed{sensor=\"left\"} 1"));
}

TEST_F(BiasTest, IsNotTakenUnderLoad) {
  const Daemon daemon = start(kHeld, {{"zero_spread_kpa", 0.1}});
  await(daemon, "unzeroed");
  const json refused = daemon.client().call("rebias", {{"sensor", "left"}})["error"];
  EXPECT_EQ(refused["code"], -32003);
  EXPECT_THAT(refused["message"].get<std::string>(), HasSubstr("looks touched"));
  EXPECT_EQ(await(daemon, "unzeroed")["gamma"], nullptr);
  EXPECT_EQ(daemon.client().call("rebias", {{"sensor", "left"}, {"force", 1}})["error"]["code"], -32602);
}

TEST_F(BiasTest, OfASensorThatReadsZeroWithoutLoadNeedsNoRequest) {
  const Daemon daemon = start(kFree, {{"zero_spread_kpa", 0}});
  await(daemon, "no_contact");
  EXPECT_EQ(zero_of(daemon)["origin"], "no_load");
  daemon.wait_for("status",
                  [](const json& status) { return status["sensors"][0]["zero"]["trouble"].is_null(); });
}

TEST_F(BiasTest, ThatIsDamagedOrOfAnotherSensorIsRefusedWithItsReason) {
  start(kFree).client().result("rebias", {{"sensor", "left"}});
  const auto file = kept();
  std::string bytes;
  {
    std::ifstream in(file, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
  }
  ASSERT_GT(bytes.size(), 1000U);
  std::string damaged = bytes;
  damaged[bytes.size() / 2] ^= 1;
  for (const auto& [content, why] : {std::pair(damaged, "is damaged: its checksum does not fit"),
                                     std::pair(bytes.substr(0, bytes.size() / 2), "is damaged or cut"),
                                     std::pair(std::string("{}"), "is damaged or cut")}) {
    std::ofstream(file, std::ios::binary) << content;
    const Daemon daemon = start(kHeld);
    EXPECT_EQ(await(daemon, "unzeroed")["gamma"], nullptr);
    EXPECT_THAT(zero_of(daemon)["trouble"].get<std::string>(), HasSubstr(why));
  }
  std::ofstream(file, std::ios::binary) << bytes;
  const Daemon daemon = start(kHeld);
  await(daemon, "ok");
}

// The simulated sensor has no serial number; another spread of its offsets makes another sensor of it.
TEST_F(BiasTest, OfASensorThatWasExchangedIsNotUsedUntilTheNewOneHasItsOwn) {
  start(kFree).client().result("rebias", {{"sensor", "left"}});
  const json other{{"zero_spread_kpa", 60}};
  for (const json& cycle : {kFree, kHeld}) {
    const Daemon daemon = start(cycle, other);
    const json told = daemon.wait_for("status", [](const json& status) {
      const json& left = status["sensors"][0];
      EXPECT_NE(left["state"], "no_contact");
      EXPECT_NE(left["state"], "ok");
      return left["zero"]["trouble"].is_string();
    });
    EXPECT_THAT(told["sensors"][0]["zero"]["trouble"].get<std::string>(),
                AllOf(HasSubstr("zero"), HasSubstr("another sensor"), HasSubstr("slipctl rebias left")));
    EXPECT_EQ(await(daemon, "unzeroed")["gamma"], nullptr);
    EXPECT_THAT(daemon.client().result("metrics").get<std::string>(),
                HasSubstr("slipd_zeroed{sensor=\"left\"} 0"));
  }
  const Daemon daemon = start(kFree, other);
  await(daemon, "unzeroed");
  EXPECT_EQ(daemon.client().result("rebias", {{"sensor", "left"}})["trouble"], nullptr);
  await(daemon, "no_contact");
}

TEST_F(BiasTest, ThatCannotBeWrittenIsUsedAndReported) {
  const Daemon daemon(config_with(folder_, json::array({sensor(kFree)})), real_drivers(),
                      {{"STATE_DIRECTORY", "/dev/full"}});
  const json taken = daemon.client().result("rebias", {{"sensor", "left"}});
  EXPECT_EQ(taken["origin"], "command");
  EXPECT_THAT(taken["trouble"].get<std::string>(), HasSubstr("/dev/full/zero"));
  await(daemon, "no_contact");
}

TEST_F(BiasTest, IsSubtractedBeforeTheGain) {
  start(kFree).client().result("rebias", {{"sensor", "left"}});
  json doubled = sensor(kHeld);
  doubled["gain"] = std::vector<double>(24 * 24, 2.0);
  const Daemon daemon(config_with(folder_, json::array({doubled})), real_drivers(),
                      {{"STATE_DIRECTORY", folder_.file("state").string()}});
  daemon.wait_for("gamma", [](const json& result) {
    const json& left = result["sensors"][0];
    return left["normal_n"].is_number() && std::fabs(left["normal_n"].get<double>() - 4) < 0.1;
  });
}

TEST_F(BiasTest, HoldsThroughAReload) {
  Daemon daemon = start(kFree);
  daemon.client().result("rebias", {{"sensor", "left"}});
  std::ofstream(daemon.config()) << config_with(folder_, json::array({sensor(kHeld)}),
                                                {{"socket", {{"path", daemon.socket().string()}}}});
  daemon.program().signal(SIGHUP);
  await(daemon, "ok");
}

TEST_F(BiasTest, ARecordingSaysWhetherItsFramesAreZeroed) {
  const auto file = [&](const char* name) { return folder_.file(name).string(); };
  const auto record = [&](const Daemon& daemon, const char* name) {
    const json account = daemon.client().record("left", 0.1, file(name));
    EXPECT_TRUE(account.contains("frames")) << account;
  };
  {
    const Daemon daemon = start(kHeld);
    await(daemon, "unzeroed");
    record(daemon, "raw.cbor");
  }
  {
    const Daemon daemon = start(kFree);
    daemon.client().result("rebias", {{"sensor", "left"}});
    record(daemon, "zeroed.cbor");
  }
  for (const auto& [name, state] :
       {std::pair("raw.cbor", "unzeroed"), std::pair("zeroed.cbor", "no_contact")}) {
    json played = sensor(kFree);
    played["driver"] = "replay";
    played["options"] = {{"file", file(name)}, {"loop", true}};
    const Daemon daemon(config_with(folder_, json::array({played})), real_drivers(),
                        {{"STATE_DIRECTORY", folder_.file("other").string()}});
    EXPECT_EQ(await(daemon, state)["gamma"], nullptr);
  }
}

}  // namespace
}  // namespace slipd::testing
