// The socket of the real daemon with valid and invalid requests. No client can prevent the next one from
// being served.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <memory>
#include <set>
#include <thread>

#include "core/recording/recording.hpp"
#include "core/storage/descriptor_passing.hpp"
#include "tests/support/daemon.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

// A deadline that is never reached, so that each notification is of a new frame.
json fine_trial(const char* name) {
  return {{"name", name},
          {"driver", "trial"},
          {"stale_after_ms", 60'000},
          {"layout", {{"grid", {20, 20}}, {"pitch_mm", 0.72}}}};
}
const json kSensors = {fine_trial("left"), fine_trial("right")};

class Socket : public ::testing::Test {
 protected:
  static json config(const TempFolder& folder) {
    return config_with(folder, kSensors,
                       {{"grasps", {{{"name", "gripper"}, {"sensors", {"left", "right"}}}}},
                        {"socket", {{"max_clients", 4}, {"mode", "0600"}}}});
  }
  static int error_code(const std::optional<std::string>& line) {
    return line ? json::parse(*line).at("error").at("code").get<int>() : 0;
  }
  // An answer shows that slipd still runs.
  void expect_served() {
    RpcClient client(daemon_.socket());
    EXPECT_EQ(client.result("version").at("name"), "slipd");
  }

  void SetUp() override {
    daemon_.wait_for("gamma", [](const json& r) {
      return r["sensors"][0]["state"] == "ok" && r["sensors"][1]["state"] == "ok";
    });
  }

  TempFolder folder_;
  Daemon daemon_{config(folder_), trial_drivers()};
};

TEST_F(Socket, GammaComesWithTruthAndUnitsAndTheGraspAddsUp) {
  const auto sum_n = [](const json& r) {
    return r["sensors"][0]["normal_n"].get<double>() + r["sensors"][1]["normal_n"].get<double>();
  };
  // An answer may have a sensor's next frame already, and the grasp's not yet.
  const json all = daemon_.wait_for("gamma", [&](const json& r) {
    const json& grasp = r["grasps"][0];
    return grasp["state"] == "ok" && std::fabs(grasp["normal_n"].get<double>() - sum_n(r)) < 1e-9;
  });
  for (const json& sensor : all["sensors"]) {
    EXPECT_NEAR(sensor["gamma"].get<double>(), sensor["truth"]["gamma"].get<double>(), 0.05);
    EXPECT_EQ(sensor["class"], 3);
    EXPECT_EQ(sensor["simulated"], true);
    EXPECT_GE(sensor["age_ms"].get<double>(), 0);
    EXPECT_NEAR(sensor["time_ns"].get<double>() * 1e-9, static_cast<double>(std::time(nullptr)), 60);
  }
  const json& grasp = all["grasps"][0];
  EXPECT_EQ(grasp["state"], "ok");
  EXPECT_NEAR(grasp["gamma"].get<double>(), 0.5, 0.05);
  EXPECT_NEAR(grasp["normal_n"].get<double>(), sum_n(all), 1e-9);
}

TEST_F(Socket, OneSensorIsAskedForByName) {
  auto client = daemon_.client();
  const json one = client.result("gamma", {{"sensor", "right"}});
  ASSERT_EQ(one["sensors"].size(), 1U);
  EXPECT_EQ(one["sensors"][0]["sensor"], "right");
  EXPECT_EQ(client.call("gamma", {{"sensor", "middle"}})["error"]["code"], -32001);
  EXPECT_THAT(client.call("gamma", {{"sensor", "middle"}})["error"]["message"].get<std::string>(),
              ::testing::HasSubstr("left, right"));
}

TEST_F(Socket, AFrameHasAColumnForEveryTaxel) {
  auto client = daemon_.client();
  const json frame = client.result("frame", {{"sensor", "left"}});
  for (const char* column : {"normal_pa", "shear_x_pa", "shear_y_pa", "x_mm", "y_mm"}) {
    EXPECT_EQ(frame[column].size(), 400U) << column;
  }
  EXPECT_NEAR(frame["x_mm"][0].get<double>(), -9.5 * 0.72, 1e-9);
}

TEST_F(Socket, WrongRequestsGetTheStandardsCodes) {
  auto client = daemon_.client();
  const auto code_of = [&](const std::string& line) {
    client.send_line(line);
    return error_code(client.line());
  };
  EXPECT_EQ(code_of("{"), -32700);
  EXPECT_EQ(code_of("hello"), -32700);
  EXPECT_EQ(code_of(std::string("\x00\xff\xfe\x80", 4)), -32700);
  EXPECT_EQ(code_of("42"), -32600);
  EXPECT_EQ(code_of("[]"), -32600);
  EXPECT_EQ(code_of(R"({"jsonrpc":"1.0","id":1,"method":"version"})"), -32600);
  EXPECT_EQ(code_of(R"({"jsonrpc":"2.0","id":{},"method":"version"})"), -32600);
  EXPECT_EQ(code_of(R"({"jsonrpc":"2.0","id":1,"method":7})"), -32600);
  EXPECT_EQ(code_of(R"({"jsonrpc":"2.0","id":1,"method":"grip"})"), -32601);
  EXPECT_EQ(code_of(R"({"jsonrpc":"2.0","id":1,"method":"frame"})"), -32602);
  EXPECT_EQ(code_of(R"({"jsonrpc":"2.0","id":1,"method":"gamma","params":["left"]})"), -32602);
  EXPECT_EQ(code_of(R"({"jsonrpc":"2.0","id":1,"method":"gamma","params":{"sensr":"left"}})"), -32602);
  EXPECT_EQ(code_of(R"({"jsonrpc":"2.0","id":1,"method":"subscribe","params":{"events":["all"]}})"), -32602);
  EXPECT_EQ(code_of(R"({"jsonrpc":"2.0","id":1,"method":"subscribe","params":{"max_rate_hz":-1}})"), -32602);
  EXPECT_EQ(code_of(R"({"jsonrpc":"2.0","id":1,"method":"rebias","params":{"sensor":"left"}})"), -32003);
  EXPECT_EQ(code_of(R"({"jsonrpc":"2.0","id":1,"method":"record","params":{"sensor":"left","seconds":0}})"),
            -32602);
  EXPECT_EQ(client.result("version")["protocol"], 1);
}

TEST_F(Socket, DeepNestingIsRefusedWhetherItIsClosedOrNot) {
  for (const std::string& open : {std::string("["), std::string("{\"a\":")}) {
    auto client = daemon_.client();
    std::string deep;
    while (deep.size() + open.size() < 60000) deep += open;
    client.send_line(deep);
    EXPECT_EQ(error_code(client.line()), -32700);
    std::string closed(30000, '[');
    closed += std::string(30000, ']');
    client.send_line(closed);
    EXPECT_EQ(error_code(client.line()), -32700);
  }
  expect_served();
}

TEST_F(Socket, ALineOver64KiBIsRefusedAndTheConnectionClosed) {
  for (const std::size_t length : {std::size_t{65537}, std::size_t{3000000}}) {
    auto client = daemon_.client();
    client.send(std::string(length, 'x'));
    const auto answer = client.line();
    ASSERT_TRUE(answer);
    EXPECT_EQ(error_code(answer), -32600);
    EXPECT_EQ(json::parse(*answer)["id"], nullptr);
    EXPECT_TRUE(client.closed_by_peer());
  }
  auto client = daemon_.client();
  const std::string request = R"({"jsonrpc":"2.0","id":1,"method":"version"})";
  client.send_line(request + std::string(65536 - request.size(), ' '));
  EXPECT_TRUE(json::parse(client.line().value()).contains("result")) << "64 KiB are still allowed";
}

TEST_F(Socket, ABatchIsAnsweredAtOnceAndNotificationsNotAtAll) {
  auto client = daemon_.client();
  client.send_line(R"([{"jsonrpc":"2.0","method":"version"},{"jsonrpc":"2.0","method":"nonsense"}])");
  client.send_line(R"({"jsonrpc":"2.0","method":"version"})");
  client.send_line(R"([{"jsonrpc":"2.0","id":"a","method":"version"},{"jsonrpc":"2.0","method":"version"},7,)"
                   R"({"jsonrpc":"2.0","id":"b","method":"frame","params":{"sensor":"left"}}])");
  const json answers = json::parse(client.line().value());
  ASSERT_EQ(answers.size(), 3U);
  EXPECT_EQ(answers[0]["id"], "a");
  EXPECT_EQ(answers[1]["error"]["code"], -32600);
  EXPECT_EQ(answers[2]["id"], "b");
}

TEST_F(Socket, AClientThatAsksWithoutReadingIsHeldBackAndThenGetsEveryAnswer) {
  auto client = daemon_.client();
  constexpr int kRequests = 3000;  // each answer is some ten times as long as its request
  std::thread asking([&] {
    for (int i = 0; i < kRequests; ++i) {
      client.send_line(R"({"jsonrpc":"2.0","id":)" + std::to_string(i) +
                       R"(,"method":"frame","params":{"sensor":"left"}})");
    }
  });
  expect_served();
  std::set<int> answered;
  while (answered.size() < kRequests) {
    const auto answer = client.line();
    ASSERT_TRUE(answer) << answered.size() << " answers came";
    answered.insert(json::parse(*answer)["id"].get<int>());
  }
  asking.join();
}

TEST_F(Socket, ALastLineWithoutItsEndIsAnswered) {
  auto client = daemon_.client();
  client.send(R"({"jsonrpc":"2.0","id":1,"method":"version"})");
  client.finish();
  EXPECT_TRUE(client.line());
  EXPECT_TRUE(client.closed_by_peer());
}

TEST_F(Socket, ALineMayComeInPieces) {
  auto client = daemon_.client();
  const std::string request = R"({"jsonrpc":"2.0","id":1,"method":"version"})"
                              "\n";
  for (const char c : request) client.send(std::string(1, c));
  EXPECT_TRUE(client.line());
}

TEST_F(Socket, SubscribersGetEstimatesUntilTheyUnsubscribe) {
  auto client = daemon_.client();
  const json id = client.result("subscribe", {{"sensors", {"left"}}, {"max_rate_hz", 100}})["subscription"];
  std::uint64_t last = 0;
  for (int i = 0; i < 5; ++i) {
    const json notified = client.notification();
    EXPECT_EQ(notified["method"], "estimate");
    EXPECT_EQ(notified["params"]["sensor"], "left");
    EXPECT_FALSE(notified.contains("id"));
    EXPECT_TRUE(notified["params"].contains("dropped"));
    EXPECT_GT(notified["params"]["seq"].get<std::uint64_t>(), last);
    last = notified["params"]["seq"];
  }
  EXPECT_EQ(client.result("unsubscribe", {{"subscription", id}}), true);
  EXPECT_EQ(client.call("unsubscribe", {{"subscription", id}})["error"]["code"], -32602);
}

TEST_F(Socket, AClientThatReadsLateLosesTheOldestAndGetsTheirNumber) {
  auto client = daemon_.client();
  client.result("subscribe", {{"sensors", {"left"}}});
  daemon_.wait_for("status", [](const json& s) { return s["outputs"]["socket"]["dropped"] > 500; });
  // Every line is whole, and each line states how many notifications were dropped before it.
  std::uint64_t dropped = 0;
  std::optional<std::uint64_t> last;
  while (dropped == 0) {
    const json notified = client.notification()["params"];
    dropped = notified["dropped"];
    const std::uint64_t sequence = notified["seq"];
    if (last) {
      EXPECT_GE(sequence - *last - 1, dropped) << "skipped frames may be missing too, dropped ones must be";
    }
    last = sequence;
  }
  EXPECT_GT(dropped, 100U);
}

TEST_F(Socket, OneClientTooManyIsRefusedWithItsReason) {
  std::vector<std::unique_ptr<RpcClient>> clients;
  for (int i = 0; i < 4; ++i) {
    clients.push_back(std::make_unique<RpcClient>(daemon_.socket()));
    clients.back()->result("version");
  }
  RpcClient fifth(daemon_.socket());
  const auto refusal = fifth.line();
  ASSERT_TRUE(refusal);
  EXPECT_THAT(*refusal, ::testing::HasSubstr("max_clients"));
  EXPECT_TRUE(fifth.closed_by_peer());
  EXPECT_EQ(clients[0]->result("status")["clients"], 4);
}

TEST_F(Socket, TheModeIsAsConfigured) {
  struct stat there {};
  ASSERT_EQ(stat(daemon_.socket().c_str(), &there), 0);
  EXPECT_EQ(there.st_mode & 0777, 0600U);
}

// Acts as another user during its lifetime.
class AsNobody {
 public:
  AsNobody() : was_(geteuid()) {
    if (seteuid(65534) != 0) throw std::runtime_error("cannot become nobody");
  }
  ~AsNobody() {
    if (seteuid(was_) != 0) std::abort();
  }
  AsNobody(const AsNobody&) = delete;
  AsNobody& operator=(const AsNobody&) = delete;

 private:
  uid_t was_;
};

TEST(Permission, OnlyRootAndSlipdsOwnUserTakeABiasAnewWhateverTheSocketsMode) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can be somebody else";
  const TempFolder folder;
  chmod(folder.path().c_str(), 0755);
  const Daemon daemon(config_with(folder, kSensors, {{"socket", {{"mode", "0666"}}}}), trial_drivers());
  const auto connect = [&](bool as_nobody) {
    const auto nobody = as_nobody ? std::make_unique<AsNobody>() : nullptr;
    return std::make_unique<RpcClient>(daemon.socket());
  };
  const auto stranger = connect(true);
  EXPECT_EQ(stranger->result("version").at("name"), "slipd") << "may ask";
  EXPECT_EQ(stranger->call("rebias", {{"sensor", "left"}}).at("error").at("code"), -32002);
  EXPECT_EQ(stranger->call("rebias", {{"sensor", "left"}, {"force", true}}).at("error").at("code"), -32002);
  const json own = connect(false)->call("rebias", {{"sensor", "left"}});
  EXPECT_TRUE(own.contains("result") || own.at("error").at("code") != -32002) << own;
}

TEST(Journal, NothingThatAClientSaysIsWrittenIntoIt) {
  const TempFolder folder;
  Daemon daemon(config_with(folder, kSensors), trial_drivers());
  auto client = daemon.client();
  client.send_line("Ada Lovelace {{{");
  client.line();
  client.call("Ada Lovelace");
  client.call("gamma", {{"sensor", "Ada Lovelace"}});
  EXPECT_EQ(daemon.stop(), 0);
  EXPECT_THAT(daemon.program().output() + daemon.program().errors(),
              ::testing::Not(::testing::HasSubstr("Ada")));
}

TEST_F(Socket, MetricsAreOpenMetricsAndAgreeWithStatus) {
  auto client = daemon_.client();
  const auto text = client.result("metrics").get<std::string>();
  EXPECT_THAT(text, ::testing::HasSubstr("slipd_frames_received_total{sensor=\"left\"} "));
  EXPECT_THAT(text, ::testing::HasSubstr("# TYPE slipd_gamma gauge\n"));
  EXPECT_THAT(text, ::testing::EndsWith("# EOF\n"));
}

TEST_F(Socket, ARecordingIsReadFromTheDescriptorThatTheAnswerCarriesAndItsEndIsTold) {
  const auto file = folder_.file("left.slipd");
  auto client = daemon_.client();
  json account;
  do {  // until some frames have come
    account = client.record("left", 0.2, file);
    ASSERT_TRUE(account.contains("frames")) << account;
  } while (account["frames"] == 0);
  EXPECT_TRUE(account["trouble"].is_null());
  EXPECT_EQ(account["sensor"], "left");
  EXPECT_EQ(account["bytes"], std::filesystem::file_size(file));
  EXPECT_GE(account["seconds"], 0.2);
  RecordingReader reader(file);
  EXPECT_EQ(reader.header().sensor, "left");
  std::vector<float> memory(1200);
  FrameSlot slot;
  slot.normal_pa = std::span(memory).subspan(0, 400);
  slot.shear_x_pa = std::span(memory).subspan(400, 400);
  slot.shear_y_pa = std::span(memory).subspan(800, 400);
  std::uint64_t frames = 0;
  while (reader.next(slot) == RecordingReader::Status::frame) ++frames;
  EXPECT_EQ(reader.fault(), "");
  EXPECT_EQ(account["frames"], frames);
}

TEST_F(Socket, ARecordingEndsWithItsClientOrItsReader) {
  const json whole_hour{{"sensor", "left"}, {"seconds", 3600}};
  auto other = daemon_.client();
  for (const bool leaves : {false, true}) {
    auto client = std::make_unique<RpcClient>(daemon_.socket());
    json answer;
    const auto until = std::chrono::steady_clock::now() + kPatience;
    do {  // the sensor can be recorded again as soon as the earlier recording has ended
      answer = client->call("record", whole_hour);
    } while (!answer.contains("result") && std::chrono::steady_clock::now() < until);
    ASSERT_TRUE(answer.contains("result")) << answer;
    UniqueFd reading = client->take_descriptor();
    ASSERT_TRUE(reading);
    EXPECT_EQ(other.call("record", whole_hour)["error"]["code"], -32003) << "it is being recorded";
    if (leaves) {
      client.reset();
      copy_to_end(std::move(reading), folder_.file("left.slipd"));
    } else {
      reading = {};
      const json told = client->notification();
      EXPECT_EQ(told["method"], "recorded");
      EXPECT_EQ(told["params"]["recording"], answer["result"]["recording"]);
      EXPECT_THAT(told["params"]["trouble"].get<std::string>(),
                  ::testing::HasSubstr("has closed its descriptor"));
    }
  }
  EXPECT_EQ(other.result("status")["recordings"]["failed"], 0);
}

TEST_F(Socket, NothingCanBeSentIntoADescriptorOfARecording) {
  auto client = daemon_.client();
  client.result("record", {{"sensor", "left"}, {"seconds", 3600}});
  const UniqueFd reading = client.take_descriptor();
  EXPECT_EQ(send_passing(reading.get(), "x", reading.get(), MSG_NOSIGNAL), -1);
  EXPECT_EQ(errno, EPIPE);
}

}  // namespace
}  // namespace slipd::testing
