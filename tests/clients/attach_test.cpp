// The method `attach` of the real slipd: what it passes, to whom, and what readers leave behind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <slipd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <thread>

#include "clients/c/board_view.hpp"
#include "core/storage/descriptor_passing.hpp"
#include "tests/support/daemon.hpp"
#include "tests/support/process_facts.hpp"

namespace slipd::testing {
namespace {

using client::BoardView;
using nlohmann::json;
using ::testing::HasSubstr;

// A connection that attaches by itself.
class Attached {
 public:
  explicit Attached(const std::filesystem::path& socket)
      : socket_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, socket.c_str(), sizeof address.sun_path - 1);
    if (connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      throw std::runtime_error("connect");
  }
  // Sends a line, and takes the answer with its descriptor.
  json ask(const std::string& line) {
    const std::string text = line + "\n";
    if (send(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL) < 0) return nullptr;
    std::string answer;
    while (answer.empty() || answer.back() != '\n') {
      char bytes[4096];
      PassedDescriptors passed;
      const auto got = receive_passed(socket_.get(), bytes, passed, 0);
      if (got <= 0) return nullptr;
      answer.append(bytes, static_cast<std::size_t>(got));
      if (passed.count > 0) file = std::move(passed.files[0]);
    }
    return json::parse(answer);
  }
  UniqueFd file;

 private:
  UniqueFd socket_;
};

constexpr const char* kAttach = R"({"jsonrpc":"2.0","id":1,"method":"attach"})";

class Attach : public ::testing::Test {
 protected:
  const TempFolder folder_;
  Daemon daemon_{
      config_with(folder_, json::array({trial_sensor("left", json::object(), {{"rate_hz", 200}})})),
      trial_drivers()};
};

TEST_F(Attach, PassesTheMemoryOnceAConnection) {
  Attached client(daemon_.socket());
  const json answer = client.ask(kAttach)["result"];
  ASSERT_TRUE(client.file);
  EXPECT_EQ(answer["sensors"], json::array({"left"}));
  struct stat facts {};
  ASSERT_EQ(fstat(client.file.get(), &facts), 0);
  EXPECT_EQ(facts.st_size, answer["bytes"]);
  BoardView view;
  EXPECT_EQ(view.map(client.file), "");
  const json again = client.ask(kAttach);
  EXPECT_EQ(again["error"]["code"], -32003) << again;
}

TEST_F(Attach, RefusesWhatItCannotPassOrWaitFor) {
  Attached client(daemon_.socket());
  EXPECT_EQ(
      client.ask(
          R"({"jsonrpc":"2.0","id":1,"method":"attach","params":{"wait":["middle"]}})")["error"]["code"],
      -32001);
  EXPECT_EQ(
      client.ask(R"({"jsonrpc":"2.0","id":1,"method":"attach","params":{"wait":"left"}})")["error"]["code"],
      -32602);
  const json batch = client.ask("[" + std::string(kAttach) + "]");
  EXPECT_THAT(batch[0]["error"]["message"].get<std::string>(), HasSubstr("send this request alone"));
  EXPECT_FALSE(client.file);
  EXPECT_TRUE(client.ask(kAttach).contains("result"));
}

// Without an answer there is nothing that a descriptor could go with.
TEST_F(Attach, AsANotificationPassesNothing) {
  Attached client(daemon_.socket());
  const std::string notification = R"({"jsonrpc":"2.0","method":"attach"})";
  const json answer = client.ask(notification + "\n" + R"({"jsonrpc":"2.0","id":2,"method":"version"})");
  EXPECT_EQ(answer["id"], 2);
  EXPECT_FALSE(client.file);
  EXPECT_TRUE(client.ask(kAttach).contains("result"));
  EXPECT_TRUE(client.file);
}

// Readers that stop, die at any moment, or attach and never read: slipd's descriptors, threads and memory,
// and the estimates of all others, stay what they were.
TEST_F(Attach, ReadersThatAreKilledLeaveNothingBehind) {
  constexpr int kSeries = 5, kReaders = 200, kAtOnce = 20;
  constexpr std::size_t kLeaked = kReaders;  // kB: a leak of a kilobyte for each reader of a series
  BoardView view;
  {
    Attached witness(daemon_.socket());
    witness.ask(kAttach);
    ASSERT_EQ(view.map(witness.file), "");
  }
  const pid_t slipd = daemon_.program().pid();
  const std::size_t descriptors = daemon_.descriptors_at_rest(), tasks = threads(slipd);
  std::minstd_rand random(20);  // NOLINT(cert-msc51-cpp): the same in every run
  const auto begun = view.record(0).number;
  std::size_t memory = resident_kb(slipd), least_growth = memory;
  for (int done = 0; done < kSeries * kReaders; done += kAtOnce) {
    std::vector<pid_t> children;
    for (int i = 0; i < kAtOnce; ++i) {
      const pid_t child = fork();
      if (child == 0) {
        slipd_client* s = nullptr;
        slipd_open(&s, daemon_.socket().c_str());
        slipd_estimate estimate;
        slipd_attach(s, "left", 10);
        for (;;) slipd_wait(s, "left", 1, 1, &estimate);
      }
      if (child < 0) {
        ADD_FAILURE() << "fork";
        break;
      }
      children.push_back(child);
    }
    for (const pid_t child : children) {
      if (random() % 4 == 0) kill(child, SIGSTOP);
      const std::chrono::microseconds moment(random() % 1000);  // so that each dies in another place
      std::this_thread::sleep_for(moment);
      kill(child, SIGKILL);
      waitpid(child, nullptr, 0);
    }
    if ((done + kAtOnce) % kReaders != 0) continue;
    EXPECT_EQ(daemon_.descriptors_at_rest(), descriptors);
    const std::size_t now = resident_kb(slipd);
    least_growth = std::min(least_growth, now > memory ? now - memory : 0);
    memory = now;
  }
#ifndef __SANITIZE_ADDRESS__  // it keeps what was freed; its own leak check runs when slipd ends
  EXPECT_LT(least_growth, kLeaked) << "memory grows in each series";
#endif
  EXPECT_EQ(threads(slipd), tasks);
  EXPECT_GT(view.record(0).number, begun);
  EXPECT_FALSE(view.closed());
}

}  // namespace
}  // namespace slipd::testing
