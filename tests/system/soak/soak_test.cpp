// Eight sensors at 1 kHz for SLIPD_SOAK_SECONDS (tools/soak), while devices and clients fail at random. The
// devices write down what they sent, so every frame can be accounted for. Memory, descriptors and threads
// must not grow.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "tests/support/daemon.hpp"
#include "tests/support/process_facts.hpp"
#include "tests/support/subscriber.hpp"
#include "tests/system/soak/disturbances.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr int kSensors = 8;
constexpr int kRateHz = 1000;
constexpr std::size_t kRecordingKb = 4096;
constexpr double kLongSeconds = 180;  // a run at least this long also tests that memory has settled

// Recordings and clients take memory while they last. The least of a period shows what is kept.
struct Memory {
  std::size_t early_kb = SIZE_MAX, late_kb = SIZE_MAX, late_most_kb = 0;
};

double wanted_seconds() {
  const char* text = std::getenv("SLIPD_SOAK_SECONDS");
  return text != nullptr ? std::stod(text) : (sanitized() ? 4 : 8);
}

std::string name_of(int sensor) {
  return "s" + std::to_string(sensor);
}

class Soak : public ::testing::Test {
 protected:
  json config() const {
    json sensors = json::array();
    for (int i = 0; i < kSensors; ++i) {
      sensors.push_back(
          trial_sensor(name_of(i),
                       {{"behaviour", "end"},
                        {"after", static_cast<std::uint64_t>(seconds_ * kRateHz)},
                        {"troubles", i + 1},
                        {"gate", folder_.file("gate").string()},
                        {"account", account_of(i).string()}},
                       {{"rate_hz", kRateHz}, {"layout", {{"grid", {8, 8}}, {"pitch_mm", 1.8}}}}));
    }
    return config_with(folder_, sensors, {{"recorder", {{"seconds", 0.2}, {"keep", 3}}}});
  }
  std::filesystem::path account_of(int sensor) const { return folder_.file("account-" + name_of(sensor)); }

  static bool all(const json& status, const std::function<bool(const json&)>& of_each) {
    return std::all_of(status["sensors"].begin(), status["sensors"].end(), of_each);
  }

  // Waits until all devices have sent their last frame.
  void watch_until_ended() {
    RpcClient asking(daemon_.socket());
    const auto begun = Clock::now();
    auto progress = begun;
    std::uint64_t last = 0;
    for (;;) {
      status_ = asking.result("status");
      std::uint64_t received = 0;
      for (const json& sensor : status_["sensors"]) received += sensor["received"].get<std::uint64_t>();
      if (received != last) progress = Clock::now();
      last = received;
      look_at_memory(std::chrono::duration<double>(Clock::now() - begun).count());
      if (all(status_, [](const json& s) {
            return s["state"] == "stale" && s["connected"] == false && s["trouble"].is_null();
          }))
        break;
      ASSERT_LT(Clock::now() - progress, kPatience) << "no progress: " << status_;
      std::this_thread::sleep_for(100ms);
    }
    took_s_ = std::chrono::duration<double>(Clock::now() - begun).count();
  }

  // Ignores the first minute, or third of the run; the rest of the run is halved into early and late.
  void look_at_memory(double elapsed_s) {
    const double settled_s = std::min(60.0, seconds_ / 3);
    const std::size_t kb = resident_kb(daemon_.program().pid());
    if (elapsed_s < settled_s) return;
    std::size_t& least_kb = elapsed_s < (settled_s + seconds_) / 2 ? memory_.early_kb : memory_.late_kb;
    least_kb = std::min(least_kb, kb);
    if (&least_kb == &memory_.late_kb) memory_.late_most_kb = std::max(memory_.late_most_kb, kb);
  }

  // Reads until both subscribers have received every notification or the report that it was dropped.
  void read_to_the_end(Subscriber& first, Subscriber& second) const {
    std::uint64_t estimated = 0;
    for (const json& sensor : status_["sensors"]) estimated += sensor["estimated"].get<std::uint64_t>();
    const auto all_reported = [&](const Subscriber& subscriber) {
      const auto all = subscriber.total();
      return all.frames + all.dropped >= estimated;
    };
    const auto until = Clock::now() + kPatience;
    for (bool more = true; Clock::now() < until;) {
      more = first.read(100ms);
      more = second.read(100ms) || more;
      const bool same = first.total().published() == second.total().published();
      if (!more && same && all_reported(first) && all_reported(second)) return;
    }
  }

  // From devices to slipd, for each sensor.
  void check_accounts_of_frames() {
    std::cout << "sensor     sent  left out  corrupt  unplugs | received  lost  estimated  skipped\n";
    for (int i = 0; i < kSensors; ++i) {
      SCOPED_TRACE(name_of(i));
      const json sent = json::parse(std::ifstream(account_of(i)));
      const json& had = status_["sensors"][static_cast<std::size_t>(i)];
      EXPECT_EQ(sent["frames"], static_cast<std::uint64_t>(seconds_ * kRateHz));
      EXPECT_EQ(had["received"], sent["frames"]);
      EXPECT_EQ(had["lost"], sent["left_out"]);
      EXPECT_EQ(had["corrupt"], sent["corrupt"]);
      EXPECT_EQ(had["reconnects"], sent["unplugs"]);
      const std::uint64_t received = had["received"], estimated = had["estimated"], skipped = had["skipped"];
      EXPECT_EQ(received, estimated + skipped);
      estimated_ += estimated;
      std::printf("%-6s %8llu %9llu %8llu %8llu | %8llu %5llu %10llu %8llu\n", name_of(i).c_str(),
                  number(sent["frames"]), number(sent["left_out"]), number(sent["corrupt"]),
                  number(sent["unplugs"]), number(had["received"]), number(had["lost"]),
                  number(had["estimated"]), number(had["skipped"]));
    }
  }
  static unsigned long long number(const json& value) { return value.get<unsigned long long>(); }

  // From slipd to subscribers. Notifications without a new frame report that a sensor is stale or gone.
  void check_account_of(const char* whose, const Subscriber& subscriber, std::uint64_t published) const {
    const auto all = subscriber.total();
    EXPECT_EQ(all.published(), published)
        << whose << ": delivered + dropped is the same for every subscriber";
    EXPECT_LE(all.frames, estimated_);
    EXPECT_GE(all.frames + all.dropped, estimated_);
    EXPECT_EQ(subscriber.broken_lines(), 0U);
    std::printf("%s: published %llu = delivered %llu + dropped %llu; of those delivered, %llu frames\n",
                whose, static_cast<unsigned long long>(published),
                static_cast<unsigned long long>(all.events), static_cast<unsigned long long>(all.dropped),
                static_cast<unsigned long long>(all.frames));
  }

  const double seconds_ = wanted_seconds();
  TempFolder folder_;
  Daemon daemon_{config(), trial_drivers(), {{"STATE_DIRECTORY", folder_.path().string()}}};
  json status_;
  std::uint64_t estimated_ = 0;  // of all sensors
  Memory memory_;
  double took_s_ = 0;
};

TEST_F(Soak, AccountsForEveryFrame) {
  const pid_t process = daemon_.program().pid();
  daemon_.wait_for("status",
                   [](const json& s) { return all(s, [](const json& e) { return e["state"] == "stale"; }); });
  const std::size_t descriptors = daemon_.descriptors_at_rest();
  const std::size_t running = threads(process);
  auto fast = std::make_unique<Subscriber>(daemon_.socket());
  auto slow = std::make_unique<Subscriber>(daemon_.socket());
  daemon_.wait_for("status", [](const json& s) { return s["clients"] == 3; });
  folder_.write("gate", "");
  {
    const BackgroundReader reading(*fast);
    const BackgroundReader reading_slowly(*slow, 10ms);
    Disturbances disturbances(daemon_, folder_, 1);
    watch_until_ended();
    const auto done = disturbances.stop();
    for (std::size_t i = 0; i < done.size(); ++i)
      std::cout << (i == 0 ? "disturbances: " : ", ") << done[i] << " " << Disturbances::kNames[i];
    std::cout << "\n";
  }
  if (HasFatalFailure()) return;
  read_to_the_end(*fast, *slow);
  check_accounts_of_frames();
  const std::uint64_t published = fast->total().published();
  check_account_of("a subscriber that reads", *fast, published);
  check_account_of("a slow subscriber", *slow, published);
  fast.reset();
  slow.reset();
  // Sensors that ended have no acquire thread any more.
  EXPECT_EQ(threads(process), running - kSensors);
  EXPECT_EQ(daemon_.descriptors_at_rest(), descriptors);
  std::printf(
      "took %.1f s; memory after its first part at least %zu kB, in its second half %zu to %zu kB; "
      "descriptors "
      "%zu\n",
      took_s_, memory_.early_kb, memory_.late_kb, memory_.late_most_kb, descriptors);
  if (!sanitized()) {
    // The allocator keeps the memory of as many recordings as ran at one time.
    EXPECT_LE(memory_.late_kb, memory_.early_kb + 2 * kRecordingKb);
    if (seconds_ >= kLongSeconds) {
      EXPECT_LE(memory_.late_most_kb, memory_.late_kb + 1024);
    }
  }
  EXPECT_EQ(daemon_.stop(), 0);
}

}  // namespace
}  // namespace slipd::testing
