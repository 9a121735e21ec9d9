// slipd is killed at random moments, the same in every run: while it starts, trains, saves and records.
// SLIPD_KILLS says how often (tools/faults). After each kill the files on disk are whole, or are refused
// with a reason, and the next start succeeds with them. The test prints how much of a recording's end is
// missing: the frames since the last flush, plus the delay of the writer, which depends on the machine.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <random>

#include "core/storage/unique_fd.hpp"
#include "paper/model/model_file.hpp"
#include "tests/support/daemon.hpp"
#include "tests/support/replayed.hpp"
#include "tests/support/subscriber.hpp"

namespace slipd::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

class Killed : public ::testing::Test {
 protected:
  // A sensor that trains a model, measures its bias and raises an alert now and then, which the flight
  // recorder keeps.
  json config() const {
    json sensors = json::array();
    sensors.push_back({{"name", "left"},
                       {"driver", "sim"},
                       {"rate_hz", 500},
                       {"layout", {{"grid", {8, 8}}, {"pitch_mm", 1.8}}},
                       {"options", {{"zeroed", false}, {"zero_spread_kpa", 1}, {"noise", 0.0005}}}});
    return config_with(
        folder_, sensors,
        {{"estimator", {{"method", "svd-knn"}}}, {"recorder", {{"seconds", 0.05}, {"keep", 5}}}});
  }
  Program::Environment environment() const { return {{"STATE_DIRECTORY", state_.path().string()}}; }

  // Runs slipd for this long and kills it. A recording of that time is in folder_/asked.rec.
  void run_and_kill(std::chrono::milliseconds length) {
    fs::remove(asked());
    newest_ = 0;
    const auto config_file = folder_.write("slipd.json", config().dump());
    Program program(folder_, "slipd",
                    {(program_folder() / "slipd").string(), "--config", config_file.string(), "--driver-dir",
                     real_drivers().string()},
                    environment());
    const auto until = Clock::now() + length;
    use(until);
    std::this_thread::sleep_until(until);
    program.signal(SIGKILL);
    EXPECT_EQ(program.wait(), 128 + SIGKILL) << program.errors();
  }

  // Records and subscribes from the moment at which the socket exists until the given time.
  void use(Clock::time_point until) {
    const fs::path socket = folder_.file("s.sock");
    while (Clock::now() < until) {
      try {
        Subscriber listening(socket);
        RpcClient recording(socket);
        recording.call("record", {{"sensor", "left"}, {"seconds", 100}});
        const Copying file(recording.take_descriptor(), asked());
        for (int turn = 0; Clock::now() < until; ++turn) {
          listening.read(5ms);
          if (turn % 20 == 10) recording.send_line(R"({"jsonrpc":"2.0","method":"flight"})");
          const auto& all = listening.counts();
          if (const auto left = all.find("left"); left != all.end()) newest_ = left->second.last_sequence;
        }
      } catch (const std::exception&) {  // the socket does not exist yet
        std::this_thread::sleep_for(1ms);
      }
    }
  }

  fs::path asked() const { return folder_.file("asked.rec"); }

  // Checks every file that slipd keeps.
  void check_kept_files() {
    for (const auto& item : fs::recursive_directory_iterator(state_.path())) {
      if (!item.is_regular_file()) continue;
      const fs::path& file = item.path();
      SCOPED_TRACE(file.string());
      if (file.extension() == ".rec") {
        const Replayed kept = replay(file);
        EXPECT_EQ(kept.fault, "") << "a file with a recording's name is whole";
        ++whole_recordings_;
      } else if (file.extension() == ".cbor" && file.filename().string().starts_with("model-")) {
        EXPECT_NO_THROW(load_model(file));
        ++whole_models_;
      }
    }
  }

  void check_recording() {
    if (!fs::exists(asked())) return;
    const Replayed kept = replay(asked());
    if (kept.frames == 0) return;
    ++recordings_;
    if (!kept.fault.empty()) {
      EXPECT_THAT(kept.fault, ::testing::HasSubstr("the recording ends with"));
      ++cut_;
    }
    EXPECT_TRUE(kept.in_order);
    if (newest_ > kept.last_sequence) {
      const auto missing_ns = static_cast<std::int64_t>(newest_ - kept.last_sequence) * 1'000'000'000 / 500;
      most_missing_ns_ = std::max(most_missing_ns_, missing_ns);
    }
  }

  const TempFolder folder_, state_;
  std::uint64_t newest_ = 0;
  std::int64_t most_missing_ns_ = 0;
  int recordings_ = 0, cut_ = 0, whole_recordings_ = 0, whole_models_ = 0;
};

int wanted_kills() {
  const char* text = std::getenv("SLIPD_KILLS");
  return text != nullptr ? std::stoi(text) : 10;
}

// A recording reaches the disk while it runs, not only at its end.
TEST_F(Killed, WhileItRecordsItLosesNoFrameThatWasOnDiskBefore) {
  Daemon daemon(config(), real_drivers(), environment());
  RpcClient recording(daemon.socket());
  daemon.wait_for("status", [](const json& s) { return s["sensors"][0]["received"] > 0; });
  recording.result("record", {{"sensor", "left"}, {"seconds", 36000}});
  const Copying file(recording.take_descriptor(), asked());
  Replayed before;
  daemon.wait_for("version", [&](const json&) {
    before = replay(asked());
    return before.frames > 100;
  });
  daemon.program().signal(SIGKILL);
  daemon.program().wait();
  const Replayed after = replay(asked());
  EXPECT_TRUE(after.in_order);
  EXPECT_GE(after.frames, before.frames);
  EXPECT_GE(after.last_sequence, before.last_sequence);
}

TEST_F(Killed, AtRandomMomentsItLeavesOnlyWholeFiles) {
  std::minstd_rand random(1);
  int kills = 0;
  while (kills < wanted_kills() && !HasFailure()) {
    SCOPED_TRACE("kill " + std::to_string(++kills));
    run_and_kill(std::chrono::milliseconds(random() % 1600));
    check_kept_files();
    check_recording();
  }
  // A last run, which ends normally, on the files that the others left.
  Daemon daemon(config(), real_drivers(), environment());
  daemon.wait_for("status", [](const json& s) { return s["sensors"][0]["estimated"] > 0; });
  EXPECT_EQ(daemon.stop(), 0);
  check_kept_files();
  for (const auto& item : fs::recursive_directory_iterator(state_.path()))
    EXPECT_THAT(item.path().filename().string(), ::testing::Not(::testing::HasSubstr(".new-")))
        << "is a temporary file";
  std::printf(
      "%d kills: %d recordings asked for, %d of them cut within a frame, at most %lld ms of frames missing "
      "at an end; "
      "kept ones looked at: %d recordings, %d models, all whole\n",
      kills, recordings_, cut_, static_cast<long long>(most_missing_ns_ / 1'000'000), whole_recordings_,
      whole_models_);
}

}  // namespace
}  // namespace slipd::testing
