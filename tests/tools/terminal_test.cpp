// The real slipctl on a real pseudo-terminal: its screen, the keys and signals that end it, and the restored
// terminal.
#include <gmock/gmock.h>
#include <poll.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>

#include "tests/tools/fake_daemon.hpp"
#include "tests/tools/run_program.hpp"
#include "tests/tools/samples.hpp"

namespace slipctl::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

FakeDaemon::Answer holding() {
  return by_method({{"sensors", [](const json&) { return sensors_sample({"left"}); }},
                    {"status", [](const json&) { return status_sample({"left"}, 100); }},
                    {"gamma",
                     [](const json&) {
                       return json{{"grasps", json::array()}};
                     }},
                    {"frame", [](const json&) { return frame_sample(16, 16); }},
                    {"subscribe", [](const json&) {
                       return json{{"subscription", 1}};
                     }}});
}

class OnTerminal : public ::testing::Test {
 protected:
  OnTerminal() {
    winsize size{24, 80, 0, 0};
    int terminal = -1;
    child_ = ::forkpty(&terminal, nullptr, nullptr, &size);
    if (child_ == 0) {
      ::setenv("TERM", "xterm-256color", 1);
      const std::string program = slipctl_program();
      ::execl(program.c_str(), "slipctl", "watch", "--socket", daemon_.path().c_str(), nullptr);
      ::_exit(127);
    }
    terminal_ = slipd::UniqueFd(terminal);
    ::tcgetattr(terminal, &before_);
  }
  ~OnTerminal() override {
    if (child_ > 0) {
      ::kill(child_, SIGKILL);
      ::waitpid(child_, nullptr, 0);
    }
  }

  // Reads until `wanted` has come; shown_ has all text so far. False if the program ended, or printed
  // nothing more, before that.
  bool shows(const std::string& wanted) {
    while (shown_.find(wanted) == std::string::npos) {
      pollfd readable{terminal_.get(), POLLIN, 0};
      std::array<char, 4096> bytes;
      if (::poll(&readable, 1, 20000) <= 0) return false;
      const ssize_t count = ::read(terminal_.get(), bytes.data(), bytes.size());
      if (count <= 0) return false;
      shown_.append(bytes.data(), static_cast<std::size_t>(count));
    }
    return true;
  }

  // The exit status once the terminal has been given back.
  int ends_and_restores() {
    EXPECT_TRUE(shows("\x1b[?25h\x1b[?1049l")) << "cursor and screen are not given back";
    int status = -1;
    ::waitpid(child_, &status, 0);
    child_ = -1;
    termios after{};
    ::tcgetattr(terminal_.get(), &after);
    EXPECT_EQ(after.c_lflag, before_.c_lflag);
    return status;
  }

  FakeDaemon daemon_{holding()};
  pid_t child_ = -1;
  slipd::UniqueFd terminal_;
  termios before_{};
  std::string shown_;
};

TEST_F(OnTerminal, DrawsTheSensorInTheAlternateScreen) {
  EXPECT_TRUE(shows("\x1b[?1049h"));
  EXPECT_TRUE(shows("left"));
  EXPECT_TRUE(shows("→"));
}

TEST_F(OnTerminal, EndsWithQ) {
  ASSERT_TRUE(shows("left"));
  ASSERT_EQ(::write(terminal_.get(), "q", 1), 1);
  EXPECT_EQ(ends_and_restores(), 0);
}

TEST_F(OnTerminal, EndsWithControlC) {
  ASSERT_TRUE(shows("left"));
  ASSERT_EQ(::write(terminal_.get(), "\x03", 1), 1);
  EXPECT_EQ(ends_and_restores(), 0);
}

TEST_F(OnTerminal, GivesTheTerminalBackWhenTerminated) {
  ASSERT_TRUE(shows("left"));
  ::kill(child_, SIGTERM);
  EXPECT_EQ(ends_and_restores(), 0);
}

TEST_F(OnTerminal, DrawsAllAnewWhenTheWindowChanges) {
  ASSERT_TRUE(shows("left"));
  shown_.clear();
  winsize larger{40, 120, 0, 0};
  ASSERT_EQ(::ioctl(terminal_.get(), TIOCSWINSZ, &larger), 0);
  EXPECT_TRUE(shows("\x1b[2J"));
  EXPECT_TRUE(shows("\x1b[40;1H"));
}

}  // namespace
}  // namespace slipctl::testing
