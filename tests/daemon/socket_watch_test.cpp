// Every socket that is ready is read before any is answered, however many there are.
#include "daemon/rpc/clients/socket_watch.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <deque>
#include <string>
#include <vector>

#include "core/storage/unique_fd.hpp"

namespace slipd {
namespace {

using Interest = SocketWatch::Interest;

// Our end of a connection; it records what it is told.
class Peer final : public SocketWatch::Watcher {
 public:
  Peer(SocketWatch& watch, std::string& course) : watch_(watch), course_(course) {
    std::array<int, 2> ends{};
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends.data()), 0);
    ours_ = UniqueFd(ends[0]);
    theirs_ = UniqueFd(ends[1]);
  }
  void wait_for(const Interest& now) { watch_.watch(ours_.get(), *this, now); }
  void says_something() const { EXPECT_EQ(write(theirs_.get(), "x", 1), 1); }
  void hangs_up() { theirs_ = {}; }
  int told() const { return told_; }
  const Interest& ready() const { return ready_; }

 private:
  void on_ready(const Interest& ready) override {
    course_ += 'r';
    ++told_;
    ready_ = ready;
    std::array<char, 8> bytes{};
    const bool ended = ready.input && read(ours_.get(), bytes.data(), bytes.size()) == 0;
    if (ended) {
      wait_for({.hang_up = true});
    } else if (!ready.input) {
      wait_for({});  // it stays ready
    }
  }
  void answer() override { course_ += 'a'; }

  SocketWatch& watch_;
  std::string& course_;
  UniqueFd ours_, theirs_;
  Interest ready_;
  int told_ = 0;
};

class SocketWatchTest : public ::testing::Test {
 protected:
  // What is ready now.
  void serve() {
    io_.restart();
    io_.poll();
  }

  asio::io_context io_;
  SocketWatch watch_{io_};
  std::string course_;
};

TEST_F(SocketWatchTest, ReadsAllThatAreReadyBeforeAnyIsAnswered) {
  std::deque<Peer> peers;
  for (int i = 0; i < 3; ++i) peers.emplace_back(watch_, course_).wait_for({.input = true});
  for (const Peer& peer : peers) peer.says_something();
  serve();
  EXPECT_EQ(course_, "rrraaa");
}

TEST_F(SocketWatchTest, LeavesNobodyOutWhenMoreAreReadyThanInOneTurn) {
  std::deque<Peer> peers;
  for (int i = 0; i < 200; ++i) peers.emplace_back(watch_, course_).wait_for({.input = true});
  for (const Peer& peer : peers) peer.says_something();
  serve();
  for (const Peer& peer : peers) EXPECT_EQ(peer.told(), 1);
}

TEST_F(SocketWatchTest, TellsOnlyWhatASocketIsWatchedFor) {
  Peer peer(watch_, course_);
  peer.wait_for({.input = true});
  peer.says_something();
  peer.wait_for({});
  serve();
  EXPECT_EQ(peer.told(), 0) << "it has input, and nobody asked";
  peer.wait_for({.room = true});
  serve();
  EXPECT_TRUE(peer.ready().room);
  EXPECT_FALSE(peer.ready().input);
}

TEST_F(SocketWatchTest, TellsThatTheOtherEndHungUp) {
  Peer peer(watch_, course_);
  peer.wait_for({.input = true});
  peer.hangs_up();
  serve();
  EXPECT_TRUE(peer.ready().hang_up);
  EXPECT_EQ(peer.told(), 2) << "once for the end of the input, then without input";
}

}  // namespace
}  // namespace slipd
