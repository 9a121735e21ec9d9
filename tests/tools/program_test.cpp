// The real slipctl against a daemon that answers from a list.
#include <gmock/gmock.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/tools/fake_daemon.hpp"
#include "tests/tools/run_program.hpp"
#include "tests/tools/samples.hpp"

namespace slipctl::testing {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

std::string contents(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

// A daemon with one sensor, which sends estimates of a grasp that slips to its subscribers.
class SlipctlWithADaemon : public ::testing::Test {
 protected:
  std::optional<std::string> answer(const Asked& asked) {
    const json request = json::parse(asked.line);
    const auto& method = request["method"].get_ref<const std::string&>();
    if (method == "sensors") return result_line(asked.line, sensors_sample({"left"}));
    if (method == "status") return result_line(asked.line, status_sample({"left"}, received_ += 100));
    if (method == "gamma")
      return result_line(asked.line,
                         {{"sensors", {estimate_sample("left", 1, 0.62)}}, {"grasps", json::array()}});
    if (method == "frame") return result_line(asked.line, frame_sample(4, 4));
    if (method == "subscribe") return result_line(asked.line, {{"subscription", 1}}) + estimates();
    if (method == "record") return recording_line(asked, "frames");
    return error_line(asked.line, -32001, "no sensor is called so");
  }

  static std::string estimates() {
    std::string lines;
    for (std::uint64_t i = 0; i < 100; ++i)
      lines += json{{"jsonrpc", "2.0"},
                    {"method", "estimate"},
                    {"params", estimate_sample("left", i, 1 - 0.01 * static_cast<double>(i))}}
                   .dump() +
               "\n";
    return lines;
  }

  Ran ask(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--socket", daemon_.path()});
    return slipctl_with(arguments);
  }

  std::atomic<std::uint64_t> received_{0};
  FakeDaemon daemon_{[this](const Asked& asked) { return answer(asked); }};
  const std::filesystem::path folder_ = temporary_folder();
  ~SlipctlWithADaemon() override { std::filesystem::remove_all(folder_); }
};

TEST(Program, EndsWithTwoOnWrongUse) {
  for (const std::vector<std::string>& wrong :
       {std::vector<std::string>{},
        {"gama"},
        {"status", "--colour"},
        {"record", "--sensor", "left"},
        {"record", "--sensor", "left", "--seconds", "-1", "--out", "x"},
        {"watch", "--seconds", "soon"},
        {"frame"}}) {
    const Ran ran = slipctl_with(wrong);
    EXPECT_EQ(ran.exit_code, 2);
    EXPECT_THAT(ran.out, IsEmpty());
    EXPECT_THAT(ran.err, Not(IsEmpty()));
  }
}

TEST(Program, EndsWithOneWithoutADaemonAndSaysWhatToDo) {
  for (const char* command : {"status", "sensors", "gamma", "watch"}) {
    const Ran ran = slipctl_with({"--socket", "/nowhere/slipd.sock", command});
    EXPECT_EQ(ran.exit_code, 1);
    EXPECT_THAT(ran.out, IsEmpty());
    EXPECT_THAT(ran.err, AllOf(StartsWith("slipctl: /nowhere/slipd.sock: slipd does not run here"),
                               HasSubstr("--socket PATH")));
  }
}

TEST(Program, NamesTheCommandThatThereIsNotAndThoseThatThereAre) {
  const Ran ran = slipctl_with({"wacth"});
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_THAT(ran.err, AllOf(StartsWith("slipctl: no such command: wacth; did you mean \"watch\"?"),
                             HasSubstr("commands are status, "), HasSubstr("rebias")));
  EXPECT_THAT(slipctl_with({"--json", "nonsense"}).err,
              StartsWith("slipctl: no such command: nonsense; commands are"));
  const Ran bare = slipctl_with({});
  EXPECT_EQ(bare.exit_code, 2);
  EXPECT_THAT(bare.err, HasSubstr("commands are"));
}

TEST(Program, RebiasAdvisesItsOwnOption) {
  const FakeDaemon touched([](const Asked& asked) {
    return error_line(asked.line, -32003, "left looks touched; let go of it, or ask with \"force\": true");
  });
  const Ran ran = slipctl_with({"--socket", touched.path(), "rebias", "left"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_THAT(ran.err, HasSubstr("or say slipctl rebias --force left"));
}

TEST(Program, FlightWaitsForTheRecordingAndFailsWithIt) {
  for (const bool full : {false, true}) {
    int looks = 0;
    const FakeDaemon recording(by_method({
        {"flight",
         [](const json&) {
           return json{{"sensors", {"left"}}, {"recordings", {3}}, {"folder", "/r"}, {"written_in_s", 0.0}};
         }},
        {"status",
         [&](const json&) {
           const bool now = ++looks > 2;
           const json one{{"sensor", "left"},
                          {"recording", now ? 3 : 2},
                          {"file", now && full ? json() : json("/r/left.rec")},
                          {"trouble", now && full ? json("No space left on device") : json()}};
           return json{{"recorder", {{"last", {one}}}}};
         }},
    }));
    const Ran ran = slipctl_with({"--socket", recording.path(), "flight"});
    EXPECT_EQ(ran.exit_code, full ? 1 : 0);
    EXPECT_THAT(full ? ran.err : ran.out, full ? "left: No space left on device\n" : "left: /r/left.rec\n");
    EXPECT_EQ(looks, 3);
  }
}

TEST_F(SlipctlWithADaemon, WatchComesBackWithTheDaemon) {
  std::atomic<int> looks{0}, subscriptions{0};
  const FakeDaemon restarting([&](const Asked& asked) -> std::optional<std::string> {
    const auto method = json::parse(asked.line)["method"];
    if (method == "subscribe") ++subscriptions;
    if (method == "status" && ++looks == 2) return std::nullopt;  // in the midst of watching
    return answer(asked);
  });
  const Ran ran = slipctl_with({"--socket", restarting.path(), "watch", "--seconds", "3"});
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_THAT(ran.err, AllOf(HasSubstr("; trying again\n"), HasSubstr("slipd is back\n")));
  EXPECT_EQ(subscriptions, 2);
}

TEST(Program, TellsItsVersionAndHelpOnStdout) {
  EXPECT_THAT(slipctl_with({"--version"}).out, StartsWith("slipctl "));
  const Ran help = slipctl_with({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  for (const char* command : {"status", "sensors", "gamma", "watch", "frame", "record", "rebias"})
    EXPECT_THAT(help.out, HasSubstr(command));
}

TEST_F(SlipctlWithADaemon, PrintsMarginsAsATable) {
  const Ran ran = ask({"gamma"});
  EXPECT_EQ(ran.exit_code, 0);
  EXPECT_THAT(ran.out, AllOf(HasSubstr("sensor  state  gamma"), HasSubstr("left    ok      0.62")));
}

// A daemon of two sensors, whose grasp is of the first.
class SlipctlWithAGrasp : public ::testing::Test {
 protected:
  Ran ask(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--socket", daemon_.path()});
    return slipctl_with(arguments);
  }

  const json grasp_{
      {"grasp", "gripper"}, {"sensors", json::array({"left"})}, {"state", "ok"}, {"gamma", 0.43}};
  const json left_ = estimate_sample("left", 1, 0.62), right_ = estimate_sample("right", 1, 0.71);
  const json gamma_{{"sensors", json::array({left_, right_})}, {"grasps", json::array({grasp_})}};
  std::atomic<bool> subscribed_to_left_{false};
  FakeDaemon daemon_{by_method({{"gamma", [this](const json&) { return gamma_; }},
                                {"sensors",
                                 [](const json&) {
                                   return sensors_sample({"left", "right"});
                                 }},
                                {"status",
                                 [](const json&) {
                                   return status_sample({"left", "right"}, 100);
                                 }},
                                {"subscribe", [this](const json& params) {
                                   subscribed_to_left_ = params["sensors"] == json::array({"left"});
                                   return json{{"subscription", 1}};
                                 }}})};
};

TEST_F(SlipctlWithAGrasp, PrintsTheMarginOfAGraspByItsName) {
  const Ran ran = ask({"gamma", "gripper"});
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_THAT(ran.out, AllOf(HasSubstr("gripper"), HasSubstr("0.43"), Not(HasSubstr("0.62"))));
  EXPECT_EQ(json::parse(ask({"--json", "gamma", "gripper"}).out),
            (json{{"sensors", json::array()}, {"grasps", json::array({grasp_})}}));
}

TEST_F(SlipctlWithAGrasp, PrintsTheMarginOfASensorWithTheGraspsThatHoldByIt) {
  EXPECT_EQ(json::parse(ask({"--json", "gamma", "left"}).out),
            (json{{"sensors", json::array({left_})}, {"grasps", json::array({grasp_})}}));
  EXPECT_EQ(json::parse(ask({"--json", "gamma", "right"}).out),
            (json{{"sensors", json::array({right_})}, {"grasps", json::array()}}));
  EXPECT_EQ(json::parse(ask({"--json", "gamma"}).out), gamma_);
}

TEST_F(SlipctlWithAGrasp, WatchesTheSensorsOfAGrasp) {
  const Ran ran = ask({"watch", "gripper", "--seconds", "0.3", "--rate", "20"});
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_THAT(ran.out, AllOf(HasSubstr("left"), Not(HasSubstr("right"))));
  EXPECT_TRUE(subscribed_to_left_);
}

TEST_F(SlipctlWithAGrasp, NamesTheSensorsAndGraspsThereAreWhenOneIsNot) {
  for (const char* command : {"gamma", "watch"}) {
    const Ran ran = ask({command, "griper"});
    EXPECT_EQ(ran.exit_code, 1);
    EXPECT_EQ(ran.err, "slipctl: there is no sensor or grasp \"griper\"; there are: left, right, gripper\n");
  }
}

TEST(Program, TellsASensorWithoutAnEstimatorFromOneWithoutFrames) {
  const auto connected_of = [](const json& method, bool receiving) {
    const json sensor{{"name", "left"}, {"method", method}, {"connected", true}, {"receiving", receiving}};
    const json answer{{"sensors", json::array({sensor})}};
    const FakeDaemon daemon(by_method({{"sensors", [&](const json&) { return answer; }}}));
    return slipctl_with({"--socket", daemon.path(), "sensors"}).out;
  };
  EXPECT_THAT(connected_of(nullptr, false), AllOf(HasSubstr("open, no estimator"), Not(HasSubstr("frames"))));
  EXPECT_THAT(connected_of("fit", false), AllOf(HasSubstr("open, no frames"), Not(HasSubstr("estimator"))));
  EXPECT_THAT(connected_of("fit", true), Not(HasSubstr("open")));
  EXPECT_THAT(connected_of(nullptr, true), Not(HasSubstr("open"))) << "a model is being trained";
}

TEST_F(SlipctlWithADaemon, PrintsTheDaemonsOwnJsonWhenAsked) {
  EXPECT_EQ(json::parse(ask({"--json", "sensors"}).out), sensors_sample({"left"}));
  EXPECT_EQ(json::parse(ask({"frame", "left", "--json"}).out), frame_sample(4, 4));
}

TEST_F(SlipctlWithADaemon, PrintsAFrameAsCsv) {
  const Ran ran = ask({"frame", "left"});
  EXPECT_THAT(ran.out, StartsWith("x_mm,y_mm,normal_pa,shear_x_pa,shear_y_pa\n"));
  EXPECT_EQ(std::count(ran.out.begin(), ran.out.end(), '\n'), 17);
}

TEST_F(SlipctlWithADaemon, PrintsTheDaemonsRefusal) {
  const Ran ran = ask({"rebias", "lfet"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_EQ(ran.err, "slipctl: no sensor is called so\n");
}

TEST_F(SlipctlWithADaemon, RecordsIntoANewFileOnly) {
  const std::string file = folder_ / "left.cbor";
  const std::vector<std::string> arguments{"record", "--sensor", "left", "--seconds", "0.1", "--out", file};
  EXPECT_EQ(ask(arguments).exit_code, 0);
  EXPECT_EQ(contents(file), "frames");
  std::ofstream(file) << "something valuable";
  const Ran again = ask(arguments);
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_THAT(again.err, HasSubstr("--force"));
  EXPECT_EQ(contents(file), "something valuable");
  std::vector<std::string> forced = arguments;
  forced.push_back("--force");
  EXPECT_EQ(ask(forced).exit_code, 0);
  EXPECT_EQ(contents(file), "frames");
}

TEST_F(SlipctlWithADaemon, ARecordingThatEndedEarlyIsKeptAndTheProgramFailsWithTheReason) {
  const std::string file = folder_ / "left.rec";
  const FakeDaemon ending([](const Asked& asked) { return recording_line(asked, "some", "slipd stops"); });
  const Ran ran = slipctl_with(
      {"--socket", ending.path(), "record", "--sensor", "left", "--seconds", "9", "--out", file});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_THAT(ran.err, HasSubstr("left.rec is not whole: slipd stops"));
  EXPECT_EQ(contents(file), "some");
}

TEST_F(SlipctlWithADaemon, ARecordingOntoAFullDiskFailsWithTheReason) {
  const Ran ran = ask({"record", "--sensor", "left", "--seconds", "9", "--out", "/dev/full", "--force"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_THAT(ran.err, HasSubstr("No space left on device"));
}

TEST_F(SlipctlWithADaemon, LeavesNoFileBehindWhenRecordingIsRefused) {
  const std::string file = folder_ / "left.cbor";
  FakeDaemon refusing([](const Asked& asked) { return error_line(asked.line, -32003, "not possible"); });
  const Ran ran =
      slipctl_with({"--socket", refusing.path(), "record", "--sensor", "l", "--seconds", "1", "--out", file});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_FALSE(std::filesystem::exists(file));
}

TEST_F(SlipctlWithADaemon, WatchesInPlainLinesWithoutATerminal) {
  const Ran ran = ask({"watch", "--seconds", "0.5", "--rate", "20"});
  EXPECT_EQ(ran.exit_code, 0);
  EXPECT_THAT(ran.out,
              AllOf(HasSubstr("left  ok  margin 0.01"), HasSubstr("alert slip"), HasSubstr("simulated")));
  EXPECT_EQ(ran.out.find('\x1b'), std::string::npos);
  EXPECT_THAT(ran.err, IsEmpty());
}

TEST_F(SlipctlWithADaemon, SumsUpWhatItSaw) {
  const Ran ran = ask({"watch", "--seconds", "0.3", "--summary", "--expect-slip"});
  EXPECT_EQ(ran.exit_code, 0);
  EXPECT_THAT(ran.out, AllOf(HasSubstr("1 warnings, 1 slips; lowest margin 0.01"), HasSubstr("ok 100.0 %"),
                             HasSubstr("mean |error| 0.0050")));
}

TEST_F(SlipctlWithADaemon, GivesEstimatesAndTheSummaryAsJsonLines) {
  std::istringstream lines(ask({"--json", "watch", "--seconds", "0.3", "--summary"}).out);
  std::vector<json> all;
  for (std::string line; std::getline(lines, line);) all.push_back(json::parse(line));
  ASSERT_EQ(all.size(), 101u);
  EXPECT_EQ(all[7]["seq"], 7);
  EXPECT_EQ(all.back()["summary"]["sensors"][0]["slips"], 1);
}

TEST_F(SlipctlWithADaemon, NamesTheSensorsThereAreWhenOneIsNot) {
  const Ran ran = ask({"watch", "rihgt"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_THAT(ran.err, AllOf(HasSubstr("rihgt"), HasSubstr("left")));
}

TEST_F(SlipctlWithADaemon, DrawsTheLastScreenAsAPicture) {
  const std::string file = folder_ / "watch.svg";
  EXPECT_EQ(ask({"watch", "--seconds", "0.3", "--picture", file}).exit_code, 0);
  EXPECT_THAT(contents(file), AllOf(StartsWith("<svg "), HasSubstr("</svg>")));
}

TEST(Watching, FailsWhenASlipWasExpectedAndNoneSeen) {
  FakeDaemon calm(by_method({{"sensors", [](const json&) { return sensors_sample({"left"}); }},
                             {"status", [](const json&) { return status_sample({"left"}, 100); }},
                             {"subscribe", [](const json&) {
                                return json{{"subscription", 1}};
                              }}}));
  const Ran ran = slipctl_with({"--socket", calm.path(), "watch", "--seconds", "0.2", "--expect-slip"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_THAT(ran.err, HasSubstr("no slip was seen"));
}

}  // namespace
}  // namespace slipctl::testing
