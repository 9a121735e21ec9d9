// How slipd starts and ends: wrong use, configurations, a second instance, files that a crash left, a stop
// while a driver hangs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>

#include "core/storage/unique_fd.hpp"
#include "tests/support/daemon.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using namespace std::chrono_literals;

const std::string kSlipd = (program_folder() / "slipd").string();

json well(const TempFolder& folder) {
  return config_with(folder, {{{"name", "left"}, {"driver", "trial"}}});
}

// A system that has no room for another descriptor to wait for once the file "refuse" is in the folder.
Program::Environment refusal(const TempFolder& folder) {
  return {{"LD_PRELOAD", std::string(SLIPD_BINARY_DIR) + "/test-bin/libslipd-epoll-refusal.so"},
          {"SLIPD_EPOLL_REFUSAL", folder.file("refuse").string()}};
}

Ran start_with(const TempFolder& folder, const std::string& config, const std::string& more = "") {
  std::vector<std::string> command{kSlipd, "--config", folder.write("c.json", config).string(),
                                   "--driver-dir", trial_drivers().string()};
  if (!more.empty()) command.push_back(more);
  return run(command);
}

TEST(Life, EndsOnSigtermAndSigint) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const TempFolder folder;
    Daemon daemon(well(folder), trial_drivers());
    RpcClient silent(daemon.socket());
    silent.result("subscribe");
    daemon.program().signal(signal);
    EXPECT_EQ(daemon.program().wait(), 0);
    EXPECT_FALSE(std::filesystem::exists(daemon.socket())) << "the socket goes with it";
    EXPECT_FALSE(std::filesystem::exists(daemon.socket().string() + ".lock"));
  }
}

TEST(Life, EndsWhileADriverHangs) {
  for (const char* behaviour : {"hang_in_read", "hang_in_open"}) {
    const TempFolder folder;
    json config = well(folder);
    config["sensors"].push_back(
        {{"name", "ill"}, {"driver", "trial"}, {"options", {{"behaviour", behaviour}, {"after", 5}}}});
    Daemon daemon(config, trial_drivers());
    const bool reads = std::string(behaviour) == "hang_in_read";
    daemon.wait_for("status", [&](const json& s) {
      return s["sensors"][0]["state"] == "ok" &&
             (!reads || (s["sensors"][1]["received"] == 5 && s["sensors"][1]["state"] == "stale"));
    });
    EXPECT_EQ(daemon.stop(), 0) << behaviour;
    EXPECT_FALSE(std::filesystem::exists(daemon.socket()));
    if (reads) {
      EXPECT_THAT(daemon.program().errors(), HasSubstr("the driver of ill does not end"));
    }
  }
}

// So that the service manager starts it again.
TEST(Life, AFatalErrorEndsItWithAnErrorAlsoWhileADriverHangs) {
  if (sanitized()) GTEST_SKIP() << "the sanitizer must be the first library";
  for (const char* behaviour : {"steady", "hang_in_read"}) {
    const TempFolder folder;
    json config = well(folder);
    config["sensors"].push_back(
        {{"name", "ill"}, {"driver", "trial"}, {"options", {{"behaviour", behaviour}, {"after", 5}}}});
    Daemon daemon(config, trial_drivers(), refusal(folder));
    daemon.wait_for("status", [](const json& s) { return s["sensors"][1]["received"] >= 5; });
    folder.write("refuse", "");
    daemon.program().signal(SIGHUP);
    EXPECT_EQ(daemon.program().wait(), 1) << behaviour;
    EXPECT_THAT(daemon.program().errors(), HasSubstr("slipd cannot go on"));
  }
}

TEST(Life, AClientThatTheSystemHasNoRoomForIsSentAwayAndTheOthersAreServed) {
  if (sanitized()) GTEST_SKIP() << "the sanitizer must be the first library";
  const TempFolder folder;
  Daemon daemon(well(folder), trial_drivers(), refusal(folder));
  RpcClient earlier(daemon.socket());
  EXPECT_EQ(earlier.result("version")["name"], "slipd");
  folder.write("refuse", "");
  EXPECT_THROW(RpcClient(daemon.socket()).result("version"), RpcClient::NoAnswer);
  EXPECT_EQ(earlier.result("version")["name"], "slipd");
  std::filesystem::remove(folder.file("refuse"));
  EXPECT_EQ(RpcClient(daemon.socket()).result("version")["name"], "slipd");
}

TEST(Life, ASecondInstanceIsRefusedAndTheFirstGoesOn) {
  const TempFolder folder;
  Daemon daemon(well(folder), trial_drivers());
  const Ran second = start_with(folder, well(folder).dump());
  EXPECT_EQ(second.code, 1);
  EXPECT_THAT(second.errors,
              HasSubstr("another slipd (process " + std::to_string(daemon.program().pid()) + ")"));
  EXPECT_EQ(daemon.client().result("version")["name"], "slipd");
}

TEST(Life, ASocketThatACrashLeftBehindIsReplaced) {
  const TempFolder folder;
  {
    Daemon crashed(well(folder), trial_drivers());
    crashed.program().signal(SIGKILL);
    crashed.program().wait();
    ASSERT_TRUE(std::filesystem::exists(crashed.socket()));
  }
  Daemon daemon(well(folder), trial_drivers());
  EXPECT_EQ(daemon.client().result("version")["name"], "slipd");
}

TEST(Life, AFileInTheSocketsPlaceIsLeftAlone) {
  const TempFolder folder;
  folder.write("s.sock", "somebody's notes");
  const Ran ran = start_with(folder, well(folder).dump());
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.errors, HasSubstr("is no socket"));
  EXPECT_EQ(std::filesystem::file_size(folder.file("s.sock")), 16U);
}

// Accepts nothing, as a program that is busy.
class ForeignListener {
 public:
  ForeignListener(const std::filesystem::path& path, int type)
      : fd_(socket(AF_UNIX, type | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    if (bind(fd_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      throw std::runtime_error("bind");
    if (type == SOCK_STREAM && listen(fd_.get(), 0) != 0) throw std::runtime_error("listen");
  }

 private:
  UniqueFd fd_;
};

ino_t inode_of(const std::filesystem::path& path) {
  struct stat status {};
  return lstat(path.c_str(), &status) == 0 ? status.st_ino : 0;
}

TEST(Life, ASocketThatAnotherProgramServesIsLeftAlone) {
  for (const int type : {SOCK_STREAM, SOCK_DGRAM}) {
    const TempFolder folder;
    const ForeignListener other(folder.file("s.sock"), type);
    const ino_t before = inode_of(folder.file("s.sock"));
    for (int i = 0; i < 3; ++i) {  // its queue is full then
      const Ran ran = start_with(folder, well(folder).dump());
      EXPECT_EQ(ran.code, 1);
      EXPECT_THAT(ran.errors, HasSubstr("another program"));
      EXPECT_THAT(ran.errors, HasSubstr("choose another socket.path"));
    }
    EXPECT_EQ(inode_of(folder.file("s.sock")), before);
  }
}

TEST(Life, WithItsLockFileGoneASecondInstanceIsRefusedStill) {
  const TempFolder folder;
  Daemon daemon(well(folder), trial_drivers());
  std::filesystem::remove(daemon.socket().string() + ".lock");
  const Ran second = start_with(folder, well(folder).dump());
  EXPECT_EQ(second.code, 1);
  EXPECT_THAT(second.errors, HasSubstr("process " + std::to_string(daemon.program().pid())));
  EXPECT_EQ(daemon.client().result("version")["name"], "slipd");
}

TEST(Life, ItRemovesItsOwnSocketAndNoOtherOfThatName) {
  const TempFolder folder;
  Daemon first(well(folder), trial_drivers());
  std::filesystem::remove(first.socket().string() + ".lock");
  std::filesystem::remove(first.socket());
  Daemon second(well(folder), trial_drivers());
  EXPECT_EQ(first.stop(), 0);
  EXPECT_EQ(second.client().result("version")["name"], "slipd");
  EXPECT_TRUE(std::filesystem::exists(second.socket().string() + ".lock"));
  EXPECT_EQ(second.stop(), 0);
  EXPECT_FALSE(std::filesystem::exists(second.socket()));
}

// Opening a pipe waits for its other end.
TEST(Life, APipeInTheConfigurationsPlaceIsRefused) {
  const TempFolder folder;
  const auto fifo = folder.file("fifo.json");
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  for (const char* more : {"--check-config", "--config"}) {
    std::vector<std::string> command{kSlipd, "--driver-dir", trial_drivers().string()};
    if (std::string(more) == "--check-config") command.emplace_back(more);
    command.insert(command.end(), {"--config", fifo.string()});
    const Ran ran = run(command);
    EXPECT_EQ(ran.code, 2);
    EXPECT_THAT(ran.errors, HasSubstr("is a pipe, not a regular file"));
  }
  Daemon daemon(well(folder), trial_drivers());
  std::filesystem::rename(fifo, daemon.config());
  daemon.program().signal(SIGHUP);
  daemon.wait_for_log("is a pipe, not a regular file");
  daemon.wait_for_log("the configuration in force stays");
  EXPECT_EQ(daemon.stop(), 0);
}

TEST(Life, APipeInADriversPlaceIsRefused) {
  const TempFolder folder;
  ASSERT_EQ(mkfifo(folder.file("slipd-driver-trial.so").c_str(), 0600), 0);
  const Ran ran = run({kSlipd, "--driver-dir", folder.path().string(), "--list-drivers"});
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.output, HasSubstr("is a pipe, not a regular file"));
}

TEST(Life, AMetricsFileThatSlipdDidNotMakeIsRefused) {
  const TempFolder folder;
  const auto refusal_of = [&](const std::filesystem::path& file) {
    json config = well(folder);
    config["metrics"] = {{"file", file.string()}};
    const Ran ran = start_with(folder, config.dump(), "--check-config");
    EXPECT_EQ(ran.code, 2) << file;
    EXPECT_THAT(ran.errors, HasSubstr("/metrics/file"));
    return ran.errors;
  };
  EXPECT_THAT(refusal_of("/etc/passwd"), HasSubstr("ends in .prom"));
  EXPECT_THAT(refusal_of(folder.write("notes.prom", "mine")), HasSubstr("slipd did not make it"));
  std::filesystem::create_symlink("/etc/passwd", folder.file("link.prom"));
  EXPECT_THAT(refusal_of(folder.file("link.prom")), HasSubstr("slipd did not make it"));
  ASSERT_EQ(mkfifo(folder.file("pipe.prom").c_str(), 0600), 0);
  EXPECT_THAT(refusal_of(folder.file("pipe.prom")), HasSubstr("slipd did not make it"));
  json config = well(folder);
  config["metrics"] = {{"file", folder.file("slipd.prom").string()}};
  folder.write("slipd.prom", "# TYPE slipd_gamma gauge\n# HELP slipd_gamma left by a crash\n");
  EXPECT_EQ(start_with(folder, config.dump(), "--check-config").code, 0);
}

TEST(Life, ASocketWhereNoneCanBeSaysWhy) {
  const TempFolder folder;
  json config = well(folder);
  config["socket"]["path"] = "/nowhere/s.sock";
  EXPECT_THAT(start_with(folder, config.dump()).errors,
              HasSubstr("/nowhere/s.sock.lock: No such file or directory"));
  config["socket"]["path"] = folder.file(std::string(150, 'x')).string();
  EXPECT_THAT(start_with(folder, config.dump()).errors, HasSubstr("1 to 107 characters"));
}

TEST(Life, AllThatIsWrongWithAConfigurationIsSaidAtOnce) {
  const TempFolder folder;
  const Ran ran = start_with(folder, R"({
    // comments are allowed
    "sensors": [ {"name": "left", "driver": "nosuch"}, {"name": "right", "driver": "trial", "rate_hz": -1},
                 {"name": "third", "driver": "trial", "options": {"behavior": "steady"}} ],
    "alert": {}, "log": {"level": 7} })");
  EXPECT_EQ(ran.code, 2);
  for (const char* place :
       {"/sensors/0/driver", "/sensors/1/rate_hz", "/sensors/2/options", "/alert", "/log/level"}) {
    EXPECT_THAT(ran.errors, HasSubstr(place));
  }
}

TEST(Life, WhatADriverRefusesIsAConfigurationError) {
  const TempFolder folder;
  json config = well(folder);
  config["sensors"][0]["options"] = {{"behaviour", "throw_in_create"}};
  const Ran ran = start_with(folder, config.dump());
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.errors, HasSubstr("/sensors/0"));
  EXPECT_THAT(ran.errors, HasSubstr("the trial device cannot be made"));
}

TEST(Life, ChecksAConfigurationWithoutServing) {
  const TempFolder folder;
  EXPECT_EQ(start_with(folder, well(folder).dump(), "--check-config").code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder.file("s.sock")));
  EXPECT_EQ(start_with(folder, "{", "--check-config").code, 2);
}

TEST(Life, ACheckNotesWhereAnotherMethodThanTheConfiguredOneIsUsed) {
  const TempFolder folder;
  json config = well(folder);
  config["estimator"]["method"] = "moments";
  EXPECT_THAT(start_with(folder, config.dump(), "--check-config").errors, Not(HasSubstr("note: ")));
  config["sensors"][0]["layout"] = {{"grid", {4, 4}}, {"pitch_mm", 4.7}};
  const Ran few = start_with(folder, config.dump(), "--check-config");
  EXPECT_EQ(few.code, 0);
  EXPECT_THAT(few.errors, HasSubstr("note: left: fit is used"));
  config["estimator"]["tracking"] = false;
  EXPECT_THAT(start_with(folder, config.dump(), "--check-config").errors, Not(HasSubstr("note: ")));
}

TEST(Life, ACheckRefusesAMethodThatCannotReadASimulatedSensorUnderItsSkin) {
  const TempFolder folder;
  const auto check = [&](const json& skin, const char* method) {
    const json config = config_with(folder, {{{"name", "left"}, {"driver", "sim"}, {"skin", skin}}},
                                    {{"estimator", {{"method", method}}}});
    return run({kSlipd, "--config", folder.write("c.json", config.dump()).string(), "--driver-dir",
                real_drivers().string(), "--check-config"});
  };
  const json deep{{"depth_mm", 1}}, bonded{{"depth_mm", 1}, {"base", "rigid"}};
  for (const char* method : {"moments", "block-fit"}) {
    const Ran ran = check(deep, method);
    EXPECT_EQ(ran.code, 2) << method;
    EXPECT_THAT(ran.errors,
                HasSubstr(std::string("/estimator/method = \"") + method + "\": sensor \"left\""));
    EXPECT_THAT(ran.errors, HasSubstr("needs the estimator's method fit, closing or auto"));
    EXPECT_EQ(check({{"depth_mm", 0}}, method).code, 0) << method;
  }
  EXPECT_THAT(check(bonded, "closing").errors, HasSubstr("/estimator/method = \"closing\": sensor \"left\""));
  for (const char* method : {"fit", "closing", "auto"}) EXPECT_EQ(check(deep, method).code, 0) << method;
}

TEST(Life, ACheckOnlyNotesWhereTheDeviceMayMeasureSomethingElse) {
  const TempFolder folder;
  json config = well(folder);
  config["estimator"]["method"] = "moments";
  config["sensors"][0]["skin"] = {{"depth_mm", 1}};
  const Ran ran = start_with(folder, config.dump(), "--check-config");
  EXPECT_EQ(ran.code, 0);
  EXPECT_THAT(ran.errors, HasSubstr("note: left: it gets no estimate if its device measures shear"));
}

TEST(Life, WrongUseIsExitTwo) {
  EXPECT_EQ(run({kSlipd}).code, 2);
  EXPECT_EQ(run({kSlipd, "--nonsense"}).code, 2);
  EXPECT_EQ(run({kSlipd, "--check-config"}).code, 2);
  EXPECT_EQ(run({kSlipd, "--config", "/nowhere/slipd.json"}).code, 2);
  EXPECT_EQ(run({kSlipd, "--version"}).code, 0);
}

TEST(Life, ListsItsDriversWithTheirOptions) {
  const Ran ran = run({kSlipd, "--driver-dir", trial_drivers().string(), "--list-drivers"});
  EXPECT_EQ(ran.code, 0);
  EXPECT_THAT(ran.output, HasSubstr("trial: a device that misbehaves"));
  EXPECT_THAT(ran.output, HasSubstr("gap_every (integer"));
}

TEST(Life, AModuleThatEverybodyMayWriteToIsNotLoaded) {
  const TempFolder folder;
  const auto copy = folder.file("slipd-driver-trial.so");
  std::filesystem::copy_file(trial_drivers() / "slipd-driver-trial.so", copy);
  chmod(copy.c_str(), 0666);
  const Ran ran = run({kSlipd, "--driver-dir", folder.path().string(), "--list-drivers"});
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.output, HasSubstr("can be written by everybody"));
  if (geteuid() != 0) GTEST_SKIP() << "only root can give a file away";
  chmod(copy.c_str(), 0644);
  ASSERT_EQ(chown(copy.c_str(), 12345, 12345), 0);
  EXPECT_THAT(run({kSlipd, "--driver-dir", folder.path().string(), "--list-drivers"}).output,
              HasSubstr("belongs to user 12345"));
}

TEST(Life, AModuleBelowAFolderThatOthersMayChangeIsNotLoaded) {
  const TempFolder folder;
  const auto inner = folder.path() / "open" / "drivers";
  std::filesystem::create_directories(inner);
  std::filesystem::copy_file(trial_drivers() / "slipd-driver-trial.so", inner / "slipd-driver-trial.so");
  chmod((inner / "slipd-driver-trial.so").c_str(), 0644);
  const auto list = [](const std::filesystem::path& drivers) {
    return run({kSlipd, "--driver-dir", drivers.string(), "--list-drivers"}).output;
  };
  EXPECT_THAT(list(inner), HasSubstr("trial: a device that misbehaves"));
  chmod((folder.path() / "open").c_str(), 0777);
  EXPECT_THAT(list(inner), HasSubstr("can be written by everybody"));
  // A link from a trusted folder does not help.
  const auto links = folder.path() / "links";
  std::filesystem::create_directories(links);
  std::filesystem::create_symlink(inner / "slipd-driver-trial.so", links / "slipd-driver-trial.so");
  EXPECT_THAT(list(links), HasSubstr("can be written by everybody"));
  if (geteuid() != 0) GTEST_SKIP() << "only root can give a folder to another group";
  ASSERT_EQ(chown((folder.path() / "open").c_str(), 0, 12345), 0);
  chmod((folder.path() / "open").c_str(), 0775);
  EXPECT_THAT(list(inner), HasSubstr("can be written by group 12345"));
}

}  // namespace
}  // namespace slipd::testing
