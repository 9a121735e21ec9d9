// slipd-modbus with a slipd that hangs, or is killed, while several PLCs poll: the real programs, and
// libmodbus as the PLC.
#include <gmock/gmock.h>
#include <modbus.h>

#include <array>
#include <csignal>
#include <fstream>
#include <functional>
#include <future>
#include <iostream>
#include <vector>

#include "bridges/modbus/register_map.hpp"
#include "tests/support/await_output.hpp"
#include "tests/support/daemon.hpp"
#include "tests/support/free_port.hpp"

namespace slipd::testing {
namespace {

using namespace slipd::modbus;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using ::testing::AnyOf;

constexpr int kPlcs = 4;
// As the settings of these tests have it, and the age from which slipd's signs of life count as old.
constexpr auto kMaxAge = 50ms, kSilent = 200ms;
// The addresses of the blocks of the sensors left, which has no alert, and right, which has one.
constexpr int kLeft = kFirstBlock, kRight = kFirstBlock + kBlockSize;
constexpr int kGamma = 2, kAlert = 10, kCause = 19;
using Answer = std::array<std::uint16_t, kFirstBlock + 2 * kBlockSize>;

class Poller {
 public:
  explicit Poller(int port) : context_(modbus_new_tcp("127.0.0.1", port)) {
    modbus_set_response_timeout(context_, std::chrono::seconds(kPatience).count(), 0);
    const auto until = Clock::now() + kPatience;
    while (modbus_connect(context_) != 0 && Clock::now() < until) {  // until slipd-modbus listens
    }
  }
  ~Poller() {
    modbus_close(context_);
    modbus_free(context_);
  }
  Poller(const Poller&) = delete;
  Poller& operator=(const Poller&) = delete;

  // None: the connection has ended.
  std::optional<Answer> poll() {
    Answer answer{};
    const auto asked = Clock::now();
    const int got = modbus_read_input_registers(context_, 0, static_cast<int>(answer.size()), answer.data());
    longest_ = std::max(longest_, Clock::now() - asked);
    return got == static_cast<int>(answer.size()) ? std::optional(answer) : std::nullopt;
  }
  // Whether there was an answer that is enough before the connection's end.
  bool await(const std::function<bool(const Answer&)>& enough) {
    const auto until = Clock::now() + kPatience;
    while (Clock::now() < until) {
      const auto answer = poll();
      if (!answer) return false;
      if (enough(*answer)) return true;
    }
    return false;
  }
  // The longest that an answer took since the last call.
  Clock::duration take_longest() { return std::exchange(longest_, {}); }

 private:
  modbus_t* context_;
  Clock::duration longest_{};
};

bool works(const Answer& answer) {
  return answer[2] == 1 && answer[kLeft] == 0 && answer[kLeft + kAlert] == 0 &&
         (answer[kRight + kAlert] == 1 || answer[kRight + kAlert] == 2);
}

// Of a request that was sent so long after slipd's end.
void expect_fail_safe(const Answer& answer, Clock::duration since) {
  if (since < kMaxAge) return;
  for (const int block : {kLeft, kRight}) {
    EXPECT_GE(answer[block], SLIPD_STATE_STALE);
    EXPECT_EQ(answer[block + kGamma], kUnknown);
  }
  EXPECT_EQ(answer[kLeft + kAlert], kUnknown) << "nobody watches";
  EXPECT_EQ(answer[kLeft + kCause], kUnknown);
  EXPECT_THAT(answer[kRight + kAlert], AnyOf(1, 2)) << "it stands";
  EXPECT_THAT(answer[kRight + kCause], AnyOf(1, 2));
  if (since < kSilent) return;
  EXPECT_EQ(answer[2], 2);
  EXPECT_EQ(answer[kLeft], SLIPD_STATE_DISCONNECTED);
  EXPECT_EQ(answer[kRight], SLIPD_STATE_DISCONNECTED);
}

// Polls from `stopped` for longer than it takes until slipd counts as silent and was asked in vain.
void poll_without_slipd(Poller& plc, Clock::time_point stopped) {
  std::optional<std::uint16_t> heartbeat;
  for (Clock::duration since{}; since < kSilent + 2s && !::testing::Test::HasFailure();) {
    since = Clock::now() - stopped;
    const auto answer = plc.poll();
    ASSERT_TRUE(answer) << modbus_strerror(errno);
    expect_fail_safe(*answer, since);
    if (since < kSilent) continue;
    EXPECT_EQ(heartbeat.value_or((*answer)[1]), (*answer)[1]);
    heartbeat = (*answer)[1];
  }
}

void await_stop(pid_t process) {
  const auto until = Clock::now() + kPatience;
  const std::string file = "/proc/" + std::to_string(process) + "/stat";
  std::string id, name, state;
  while (state != "T" && Clock::now() < until) std::ifstream(file) >> id >> name >> state;
  EXPECT_EQ(state, "T");
}

class ModbusWithoutSlipd : public ::testing::Test {
 protected:
  ModbusWithoutSlipd()
      : config_(config_with(folder_, nlohmann::json::array(
                                         {trial_sensor("left"), trial_sensor("right", {{"gamma", 0.05}})}))),
        slipd_(std::make_unique<Daemon>(config_, trial_drivers())),
        port_(free_port()),
        bridge_(folder_, "modbus",
                {(program_folder() / "slipd-modbus").string(), "--config",
                 folder_
                     .write("modbus.json", nlohmann::json{{"port", port_},
                                                          {"socket", slipd_->socket().string()},
                                                          {"max_age_ms", kMaxAge.count()}}
                                               .dump())
                     .string()}) {
    for (int i = 0; i < kPlcs; ++i) plcs_.push_back(std::make_unique<Poller>(port_));
  }
  void all_plcs(const std::function<void(Poller&)>& task) {
    std::vector<std::future<void>> running;
    for (const auto& plc : plcs_)
      running.push_back(std::async(std::launch::async, [&task, &plc] { task(*plc); }));
  }
  void print_longest(const char* while_what) {
    Clock::duration longest{};
    for (const auto& plc : plcs_) longest = std::max(longest, plc->take_longest());
    std::cout << "longest answer while slipd " << while_what << ": "
              << std::chrono::duration<double, std::milli>(longest).count() << " ms\n";
  }
  void expect_work() {
    all_plcs([](Poller& plc) { EXPECT_TRUE(plc.await(works)); });
  }

  TempFolder folder_;
  nlohmann::json config_;
  std::unique_ptr<Daemon> slipd_;
  int port_;
  Program bridge_;
  std::vector<std::unique_ptr<Poller>> plcs_;
};

TEST_F(ModbusWithoutSlipd, EveryPlcIsAnsweredAndToldWhileSlipdHangs) {
  expect_work();
  print_longest("works");
  slipd_->program().signal(SIGSTOP);
  await_stop(slipd_->program().pid());
  const auto stopped = Clock::now();
  all_plcs([stopped](Poller& plc) { poll_without_slipd(plc, stopped); });
  print_longest("hangs");
  // Settings that are read again, and a connection that is new, do not wait for it either.
  bridge_.signal(SIGHUP);
  EXPECT_FALSE(plcs_.front()->await([](const Answer&) { return false; })) << "connections are made anew";
  Poller fresh(port_);
  const auto answer = fresh.poll();
  ASSERT_TRUE(answer);
  EXPECT_EQ((*answer)[2], 2);
  slipd_->program().signal(SIGCONT);
  EXPECT_TRUE(fresh.await(works));
  bridge_.signal(SIGTERM);
  EXPECT_EQ(bridge_.wait(), 0);
}

TEST_F(ModbusWithoutSlipd, NamesOfBlocksThatSlipdDoesNotHaveAreToldOnceUntilTheyChange) {
  const int port = free_port();
  const nlohmann::json settings{
      {"port", port}, {"socket", slipd_->socket().string()}, {"blocks", {"right", "lefft", "rihgt"}}};
  Program bridge(folder_, "misspelt",
                 {(program_folder() / "slipd-modbus").string(), "--config",
                  folder_.write("misspelt.json", settings.dump()).string()});
  const std::string both = R"(slipd has no sensor or grasp "lefft", "rihgt")";
  EXPECT_TRUE(await_errors(bridge, both));
  const auto restart_slipd = [&] {
    slipd_.reset();
    slipd_ = std::make_unique<Daemon>(config_, trial_drivers());
  };
  restart_slipd();
  EXPECT_TRUE(Poller(port).await([](const Answer& answer) { return answer[2] == 1; }));
  config_["sensors"][0]["name"] = "lefft";
  restart_slipd();
  EXPECT_TRUE(await_errors(bridge, R"(slipd has no sensor or grasp "rihgt")"));
  EXPECT_EQ(bridge.errors().find(both), bridge.errors().rfind(both)) << bridge.errors();
}

TEST_F(ModbusWithoutSlipd, EveryPlcIsAnsweredAndToldOnceSlipdWasKilled) {
  expect_work();
  slipd_->program().signal(SIGKILL);
  slipd_->program().wait();
  const auto killed = Clock::now();
  all_plcs([killed](Poller& plc) { poll_without_slipd(plc, killed); });
  print_longest("is dead");
  slipd_.reset();
  slipd_ = std::make_unique<Daemon>(config_, trial_drivers());
  expect_work();
  EXPECT_THAT(bridge_.errors(), ::testing::HasSubstr("answers PLCs on 127.0.0.1:" + std::to_string(port_)));
  EXPECT_THAT(bridge_.errors(), ::testing::HasSubstr(config_["socket"]["path"].get<std::string>()));
  EXPECT_THAT(bridge_.errors(), ::testing::HasSubstr("2 sensors"));
}

}  // namespace
}  // namespace slipd::testing
