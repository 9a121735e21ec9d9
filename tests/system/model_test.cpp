// Models are trained on first use, kept on disk, and trained again when the file is damaged.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <iterator>

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

TEST_F(Models, OnlyASceneThatNamesATrainedMethodLoadsTheirModule) {
  const json sensor =
      trial_sensor("left", json::object(), {{"layout", {{"grid", {12, 12}}, {"pitch_mm", 1.2}}}});
  for (const char* method : {"auto", "moments", "fit", "closing"}) {
    const TempFolder folder;
    Daemon daemon(config_with(folder, json::array({sensor}), {{"estimator", {{"method", method}}}}),
                  trial_drivers());
    daemon.wait_for("status", [](const json& s) { return s["sensors"][0]["estimated"] > 0; });
    EXPECT_THAT(mapped_by(daemon.program().pid()), Not(HasSubstr("slipd-paper"))) << method;
  }
  const auto trained = start();
  EXPECT_THAT(mapped_by(trained->program().pid()), HasSubstr("slipd-paper.so"));
}

// A copy of slipd beside drivers of its own.
class OtherPlace : public ::testing::Test {
 protected:
  OtherPlace() {
    std::filesystem::create_directories(folder_.path() / "bin");
    std::filesystem::create_directories(modules());
    std::filesystem::copy_file(program_folder() / "slipd", slipd());
    std::filesystem::copy_file(trial_drivers() / "slipd-driver-trial.so",
                               modules() / "slipd-driver-trial.so");
  }
  std::filesystem::path modules() const { return folder_.path() / "drivers"; }
  std::filesystem::path slipd() const { return folder_.path() / "bin" / "slipd"; }
  Ran check(const char* method) const {
    const json sensor =
        trial_sensor("left", json::object(), {{"layout", {{"grid", {12, 12}}, {"pitch_mm", 1.2}}}});
    const auto config = folder_.write(
        "c.json", config_with(folder_, json::array({sensor}), {{"estimator", {{"method", method}}}}).dump());
    return run({slipd().string(), "--check-config", "--config", config.string()});
  }
  TempFolder folder_;
};

TEST_F(OtherPlace, AMissingModuleIsAMistakeOfTheConfigurationThatSaysWhatToInstall) {
  const Ran fine = check("auto");
  EXPECT_EQ(fine.code, 0) << fine.errors;
  for (const char* method : {"svd-knn", "registered"}) {
    const Ran refused = check(method);
    EXPECT_EQ(refused.code, 2);
    EXPECT_THAT(refused.errors, HasSubstr(std::string("/estimator/method = \"") + method + "\""));
    EXPECT_THAT(refused.errors, HasSubstr("the package slipd-paper, which is not installed"));
    EXPECT_THAT(refused.errors, HasSubstr("auto, moments, fit, block-fit and closing need nothing more"));
  }
  std::filesystem::copy_file(real_drivers() / "slipd-paper.so", modules() / "slipd-paper.so");
  const Ran there = check("svd-knn");
  EXPECT_EQ(there.code, 0) << there.errors;
}

TEST_F(OtherPlace, AModuleThatOthersCanWriteOrThatIsCutOrForeignIsNotLoaded) {
  const auto file = modules() / "slipd-paper.so";
  std::filesystem::copy_file(real_drivers() / "slipd-paper.so", file);
  std::filesystem::permissions(file, std::filesystem::perms::others_write,
                               std::filesystem::perm_options::add);
  EXPECT_THAT(check("svd-knn").errors, HasSubstr("can be written by everybody"));
  std::filesystem::permissions(file, std::filesystem::perms::others_write,
                               std::filesystem::perm_options::remove);
  std::filesystem::resize_file(file, 4096);  // half of it may be debug information
  EXPECT_THAT(check("svd-knn").errors, HasSubstr("cut short"));
  std::filesystem::copy_file(trial_drivers() / "slipd-driver-trial.so", file,
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_THAT(check("svd-knn").errors, HasSubstr("of the same version as slipd"));
}

// Every name of FLANN's begins with its namespace, as compilers write it.
TEST(Programs, ThatRunWithoutTrainedMethodsContainNothingOfThem) {
  const auto contains_flann = [](const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    EXPECT_FALSE(bytes.empty()) << file;
    return bytes.find("5flann") != std::string::npos;
  };
  EXPECT_TRUE(contains_flann(real_drivers() / "slipd-paper.so"));
  EXPECT_FALSE(contains_flann(program_folder() / "slipd"));
  EXPECT_FALSE(contains_flann(program_folder() / "slipctl"));
  EXPECT_FALSE(contains_flann(real_drivers() / "slipd-driver-sim.so"));
}

}  // namespace
}  // namespace slipd::testing
