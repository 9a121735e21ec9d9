// Clients that pass descriptors, which slipd takes none of: whatever files are behind them, whoever closes
// them last, slipd answers others, reloads and stops. Closing a lingering connection takes an hour here, so
// whatever waits for one fails the test. The longest time to an answer is printed. Refused: a kernel that
// refuses descriptors for slipd. Passed: one that cannot, as before Linux 6.16.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <deque>
#include <fstream>
#include <memory>
#include <random>
#include <thread>

#include "tests/support/await_output.hpp"
#include "tests/support/daemon.hpp"
#include "tests/support/passed_files.hpp"
#include "tests/support/process_facts.hpp"
#include "tests/support/silent_fuse.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kClosingThreads = 16;
constexpr std::size_t kAllowedAboveIdleKb = 64 * 1024;  // above idle

// Asks slipd for its version again and again, and keeps the longest time to an answer.
class Asking {
 public:
  explicit Asking(const std::filesystem::path& socket)
      : client_(socket), thread_([this](const std::stop_token& stop) { run(stop); }) {}
  // Ends after some more answers, and returns the longest time, ms.
  double longest_ms() {
    for (const int enough = answers_ + 20; answers_ < enough;) std::this_thread::yield();
    thread_ = {};
    return longest_ms_;
  }

 private:
  void run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      const auto begin = Clock::now();
      client_.result("version");
      longest_ms_ =
          std::max(longest_ms_, std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
      ++answers_;
    }
  }
  RpcClient client_;
  double longest_ms_ = 0;
  std::atomic<int> answers_{0};
  std::jthread thread_;
};

// How many threads of slipd are closing something.
std::size_t closing(pid_t process) {
  std::size_t count = 0;
  std::error_code ignored;
  for (const auto& task :
       std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task", ignored)) {
    std::ifstream comm(task.path() / "comm");
    std::string name;
    count += std::getline(comm, name) && name == "close" ? 1 : 0;
  }
  return count;
}

// Of a slipd whose kernel has no SO_PASSRIGHTS. AddressSanitizer wants to be the first library otherwise.
Program::Environment older_kernel() {
  const char* const options = std::getenv("ASAN_OPTIONS");
  return {
      {"LD_PRELOAD", std::string(SLIPD_BINARY_DIR) + "/test-bin/libslipd-older-kernel.so"},
      {"ASAN_OPTIONS", (options == nullptr ? "" : options + std::string(":")) + "verify_asan_link_order=0"}};
}

class Passing : public ::testing::Test {
 protected:
  explicit Passing(const Program::Environment& environment) : environment_(environment) {}
  std::size_t closing() const { return testing::closing(daemon_.program().pid()); }
  void expect_turned_away(RpcClient& client) const {
    const auto line = client.line();
    ASSERT_TRUE(line);
    EXPECT_THAT(*line, HasSubstr("takes no descriptors"));
    EXPECT_THAT(*line, HasSubstr("-32600"));
    EXPECT_TRUE(client.closed_by_peer());
  }
  // So many clients, each of which has passed a descriptor that slipd is the last to hold: slipd is paused
  // meanwhile. (Once only: a pause ends the closing of a lingering connection.)
  std::vector<std::unique_ptr<RpcClient>> pass_lingering(std::size_t clients, const SilentPeer& peer) const {
    std::vector<std::unique_ptr<RpcClient>> made;
    for (std::size_t i = 0; i < clients; ++i) made.push_back(std::make_unique<RpcClient>(daemon_.socket()));
    daemon_.program().signal(SIGSTOP);
    const std::string stat = "/proc/" + std::to_string(daemon_.program().pid()) + "/stat";
    for (std::string text; text.find(") T ") == std::string::npos;) std::getline(std::ifstream(stat), text);
    for (std::size_t i = 0; i < clients; ++i) {
      // The kernel would drop a byte out of band, and what it bears, on its own.
      const int flags = i % 3 == 0 ? MSG_OOB : 0;
      EXPECT_EQ(send_passing(made[i]->fd(), "\n", peer.lingering().get(), flags | MSG_NOSIGNAL), 1);
      made[i]->send("\n");
    }
    daemon_.program().signal(SIGCONT);
    return made;
  }
  template <typename Done>
  void timed(const char* what, int signal, Done done) {
    const auto begin = Clock::now();
    daemon_.program().signal(signal);
    done();
    std::printf("%s: %.0f ms\n", what,
                std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
  }
  void expect_reload_and_stop() {
    timed("reload", SIGHUP, [&] { daemon_.wait_for_log("the new configuration is in force"); });
    timed("stop", SIGTERM, [&] { EXPECT_EQ(daemon_.program().wait(), 0); });
  }

  void a_thousand_do_anything();

 private:
  const Program::Environment environment_;

 protected:
  TempFolder folder_;
  SilentPeer peer_;
  Daemon daemon_{config_with(folder_, json::array({trial_sensor("left")})), trial_drivers(), environment_};
};

class Passed : public Passing {
 protected:
  Passed() : Passing(older_kernel()) {}
};

class Refused : public Passing {
 protected:
  Refused() : Passing({}) {}
  void SetUp() override {
    const auto ends = socket_pair();
    refuse_descriptors(ends[0].get());
    if (!refuses_descriptors(ends[0].get())) GTEST_SKIP() << "this kernel cannot; Linux 6.16 and later can";
  }
};

TEST_F(Passed, OfAnyKindAndAnywhereInWhatIsSentTheClientIsTurnedAway) {
  Asking asking(daemon_.socket());
  for (int kind = 0; kind < kPassedKinds - 1; ++kind) {
    for (const bool after_a_request : {false, true}) {
      RpcClient client(daemon_.socket());
      if (after_a_request) client.result("version");
      UniqueFd file = passed_file(static_cast<PassedKind>(kind), peer_, daemon_.socket());
      client.send(R"({"jsonrpc":"2.0","id":1,"method":"version"})"
                  "\n",
                  file.get());
      close_elsewhere(std::move(file));
      expect_turned_away(client);
    }
  }
  std::printf("longest answer: %.1f ms\n", asking.longest_ms());
  expect_reload_and_stop();
}

// More than there are threads that close.
TEST_F(Passed, ThatLingerHoldUpNeitherAnswersNorReloadNorStop) {
  const auto hostile = pass_lingering(2 * kClosingThreads, peer_);
  Asking asking(daemon_.socket());
  for (const auto& client : hostile) expect_turned_away(*client);
  daemon_.wait_for("version", [&](const json&) { return closing() == kClosingThreads; });
  const json status = daemon_.wait_for("status", [](const json&) { return true; });
  EXPECT_GE(status["clients"], kClosingThreads) << "those that cannot be closed yet keep their places";
  std::printf("longest answer while %zu threads close: %.1f ms\n", closing(), asking.longest_ms());
  expect_reload_and_stop();
}

TEST_F(Passed, ThatLingerAreClosedAndGiveTheirPlacesBackWhenTheirPeersEnd) {
  {
    const SilentPeer ending;
    for (const auto& client : pass_lingering(2 * kClosingThreads, ending)) expect_turned_away(*client);
    daemon_.wait_for("version", [&](const json&) { return closing() == kClosingThreads; });
  }
  daemon_.wait_for("status", [&](const json& s) { return s["clients"] == 1 && closing() == 0; });
}

TEST_F(Passed, OfAFileSystemThatNeverAnswersHoldUpNothing) {
  const TempFolder folder;
  const SilentFuse silent(folder.path());
  if (!silent.mounted()) GTEST_SKIP() << "mounting a file system in user space needs root and /dev/fuse";
  Asking asking(daemon_.socket());
  for (int i = 0; i < 8; ++i) {
    RpcClient client(daemon_.socket());
    UniqueFd file = silent.file();
    ASSERT_TRUE(file);
    client.send("\n", file.get());
    close_elsewhere(std::move(file));
    expect_turned_away(client);
  }
  std::printf("longest answer: %.1f ms\n", asking.longest_ms());
  expect_reload_and_stop();
}

// Descriptors in connections that slipd has not accepted, and in what it has not read.
TEST_F(Passed, BeforeTheyAreReadHoldUpNoStop) {
  std::vector<std::unique_ptr<RpcClient>> hostile;
  hostile.push_back(std::make_unique<RpcClient>(daemon_.socket()));
  hostile.back()->result("version");
  daemon_.program().signal(SIGSTOP);
  for (int i = 0; i < 20; ++i) {
    if (i > 0) hostile.push_back(std::make_unique<RpcClient>(daemon_.socket()));
    hostile.back()->send("\n", peer_.lingering().get());
  }
  daemon_.program().signal(SIGTERM);
  timed("stop", SIGCONT, [&] { EXPECT_EQ(daemon_.program().wait(), 0); });
}

// A client that does anything, by chance.
class Anything {
 public:
  Anything(const std::filesystem::path& socket, const SilentPeer& peer, std::minstd_rand& random,
           int& lingering)
      : client_(socket), peer_(peer), socket_(socket), random_(random), lingering_(lingering) {
    for (int steps = up_to(4); steps > 0; --steps) step();
  }

 private:
  int up_to(unsigned most) { return static_cast<int>(1 + random_() % most); }
  void step() {
    static const std::array<std::string, 7> kLines{
        R"({"jsonrpc":"2.0","id":1,"method":"gamma"})"
        "\n",
        R"({"jsonrpc":"2.0","id":2,"method":"subscribe"})"
        "\n",
        R"({"jsonrpc":"2.0","id":3,"method":"record","params":{"sensor":"left","seconds":3600}})"
        "\n",
        R"({"jsonrpc":"2.0","id":4,"method":"attach"})"
        "\n",
        R"({"jsonrpc":"2.0","id":5,"method":"frame","params":{"sensor":"left"}})"
        "\n",
        "nonsense\n",
        R"({"jsonrpc":"2.0","id":6,)"};
    const std::string& line = kLines[random_() % kLines.size()];
    switch (random_() % 6) {
      case 0:
        client_.finish();
        break;
      case 1:
      case 2: {
        UniqueFd file = any_file();
        send_passing(client_.fd(), line, file.get(),
                     MSG_NOSIGNAL | MSG_DONTWAIT | (random_() % 4 == 0 ? MSG_OOB : 0));
        close_elsewhere(std::move(file));
        break;
      }
      default:
        send_passing(client_.fd(), line, -1, MSG_NOSIGNAL | MSG_DONTWAIT);
    }
  }
  // At most so many linger that places are left for the others.
  UniqueFd any_file() {
    auto kind = static_cast<PassedKind>(random_() % kPassedKinds);
    if (kind == PassedKind::board) kind = PassedKind::memory;  // which waits for an answer
    if ((kind == PassedKind::lingering || kind == PassedKind::nested) && ++lingering_ > 40)
      kind = PassedKind::epoll;
    return passed_file(kind, peer_, socket_);
  }

  RpcClient client_;
  const SilentPeer& peer_;
  std::filesystem::path socket_;
  std::minstd_rand& random_;
  int& lingering_;
};

void Passing::a_thousand_do_anything() {
  constexpr int kThousand = 1000;
  constexpr std::size_t kAtOnce = 20;
  std::minstd_rand random(1);
  int lingering = 0;
  const std::size_t idle_kb = resident_kb(daemon_.program().pid());
  std::size_t most_kb = 0;
  Asking asking(daemon_.socket());
  std::deque<std::unique_ptr<Anything>> connected;
  for (int i = 0; i < kThousand; ++i) {
    connected.push_back(std::make_unique<Anything>(daemon_.socket(), peer_, random, lingering));
    if (connected.size() > kAtOnce) connected.erase(connected.begin() + random() % kAtOnce);
    most_kb = std::max(most_kb, resident_kb(daemon_.program().pid()));
  }
  std::printf("%d clients: longest answer %.1f ms; resident %zu kB idle, at most %zu kB; %zu threads close\n",
              kThousand, asking.longest_ms(), idle_kb, most_kb, closing());
  if (!sanitized()) {
    EXPECT_LE(most_kb, idle_kb + kAllowedAboveIdleKb);
  }
}

TEST_F(Passed, AmongAnythingThatAThousandClientsDoByChanceOthersAreAnswered) {
  a_thousand_do_anything();
  EXPECT_GT(closing(), 0U);
  expect_reload_and_stop();
}

TEST_F(Refused, AmongAnythingThatAThousandClientsDoByChanceOthersAreAnswered) {
  a_thousand_do_anything();
  EXPECT_EQ(closing(), 0U);
  expect_reload_and_stop();
}

TEST_F(Refused, OfAnyKindNoneIsSentAndTheClientIsServedAsBefore) {
  for (int kind = 0; kind < kPassedKinds - 1; ++kind) {
    RpcClient client(daemon_.socket());
    UniqueFd file = passed_file(static_cast<PassedKind>(kind), peer_, daemon_.socket());
    for (const int flags : {0, int{MSG_OOB}}) {
      EXPECT_EQ(send_passing(client.fd(), "\n", file.get(), flags | MSG_NOSIGNAL), -1);
      EXPECT_EQ(errno, EPERM);
    }
    close_elsewhere(std::move(file));
    EXPECT_EQ(client.result("version")["name"], "slipd");
  }
}

TEST_F(Refused, BeforeTheConnectionIsAcceptedNoneIsSentEither) {
  daemon_.program().signal(SIGSTOP);
  RpcClient client(daemon_.socket());
  UniqueFd file = peer_.lingering();
  EXPECT_FALSE(client.send("\n", file.get()));
  EXPECT_EQ(errno, EPERM);
  close_elsewhere(std::move(file));
  daemon_.program().signal(SIGCONT);
  EXPECT_EQ(client.result("version")["name"], "slipd");
}

// slipd gets the listener with clients that connected when the kernel refused nothing.
TEST_F(Refused, WhoConnectedBeforeSlipdStartedIsTurnedAway) {
  const std::filesystem::path activate = "/usr/bin/systemd-socket-activate";
  if (!std::filesystem::exists(activate)) GTEST_SKIP() << activate << " is not installed";
  const TempFolder folder;
  const auto socket = folder.file("passed.sock");
  const auto config = folder.write("c.json", config_with(folder, json::array({trial_sensor("left")})).dump());
  Program program(folder, "slipd",
                  {activate.string(), "--listen=" + socket.string(), (program_folder() / "slipd").string(),
                   "--config", config.string(), "--driver-dir", trial_drivers().string()},
                  {{"SYSTEMD_LOG_LEVEL", "info"}});
  ASSERT_TRUE(await_errors(program, "Listening on " + socket.string()));
  const UniqueFd memory(memfd_create("passed", MFD_CLOEXEC));
  RpcClient early(socket);  // what slipd is started for
  // A service manager that is newer than Debian 12's may refuse them for slipd.
  if (early.send("\n", memory.get())) {
    expect_turned_away(early);
  } else {
    EXPECT_EQ(early.result("version")["name"], "slipd");
  }
  RpcClient late(socket);
  EXPECT_FALSE(late.send("\n", memory.get()));
  EXPECT_EQ(errno, EPERM);
}

}  // namespace
}  // namespace slipd::testing
