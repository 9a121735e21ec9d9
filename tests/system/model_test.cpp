// Models are trained on first use, kept on disk, and trained again when the file is damaged.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include "tests/support/daemon.hpp"
#include "tests/support/process_facts.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class Models : public ::testing::Test {
 protected:
  std::unique_ptr<Daemon> start(int side = 12) {
    const json sensor{{"name", "left"},
                      {"driver", "trial"},
                      {"layout", {{"grid", {side, side}}, {"pitch_mm", 14.4 / side}}}};
    return std::make_unique<Daemon>(
        config_with(folder_, json::array({sensor}), {{"estimator", {{"method", "svd-knn"}}}}),
        trial_drivers(), Program::Environment{{"STATE_DIRECTORY", folder_.path().string()}});
  }
  static std::string wait_until_estimating(Daemon& daemon) {
    daemon.wait_for("status", [](const json& s) { return s["sensors"][0]["estimated"] > 0; });
    EXPECT_EQ(daemon.client().result("sensors")["sensors"][0]["method"], "svd-knn");
    EXPECT_EQ(daemon.stop(), 0);
    return daemon.program().errors();
  }
  std::filesystem::path model() const {
    for (const auto& file : std::filesystem::recursive_directory_iterator(folder_.path() / "models")) {
      if (file.is_regular_file()) return file.path();
    }
    throw std::runtime_error("no model was kept");
  }
  TempFolder folder_;
};

TEST_F(Models, AreTrainedOnceAndMadeAnewWhenDamaged) {
  auto first = start();
  EXPECT_EQ(first->client().result("gamma")["sensors"][0]["gamma"], nullptr) << "nothing is known yet";
  EXPECT_THAT(wait_until_estimating(*first), HasSubstr("left: training: 100 %"));

  EXPECT_THAT(wait_until_estimating(*start()), Not(HasSubstr("training")));

  std::filesystem::resize_file(model(), std::filesystem::file_size(model()) / 2);
  const std::string said = wait_until_estimating(*start());
  EXPECT_THAT(said, HasSubstr(model().string()));
  EXPECT_THAT(said, HasSubstr("made anew"));
}

// The training process is stopped, so it never ends by itself.
TEST_F(Models, ATrainingUnderWayDoesNotHoldUpAStop) {
  auto daemon = start(60);
  pid_t training = 0;
  daemon->wait_for("version", [&](const json&) {
    training = child_of(daemon->program().pid());
    return training != 0;
  });
  ASSERT_EQ(kill(training, SIGSTOP), 0);
  EXPECT_EQ(daemon->stop(), 0);
}

TEST_F(Models, AreNotTrainedForFewTrackedTaxelsWhichAlwaysUseFit) {
  const json sensor{{"name", "left"}, {"driver", "trial"}, {"layout", {{"grid", {4, 4}}, {"pitch_mm", 4.7}}}};
  Daemon daemon(config_with(folder_, json::array({sensor}), {{"estimator", {{"method", "svd-knn"}}}}),
                trial_drivers(), Program::Environment{{"STATE_DIRECTORY", folder_.path().string()}});
  daemon.wait_for("status", [](const json& s) { return s["sensors"][0]["estimated"] > 0; });
  EXPECT_EQ(daemon.client().result("status")["sensors"][0]["method"], "fit");
  EXPECT_EQ(daemon.client().result("sensors")["sensors"][0]["method"], "fit");
  EXPECT_EQ(daemon.stop(), 0);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "models"));
  const std::string said = daemon.program().errors(), replaced = "left: fit is used and not the configured";
  EXPECT_THAT(said, Not(HasSubstr("training")));
  const auto first = said.find(replaced);
  ASSERT_NE(first, std::string::npos) << said;
  EXPECT_EQ(said.find(replaced, first + 1), std::string::npos) << "once is enough: " << said;
}

}  // namespace
}  // namespace slipd::testing
