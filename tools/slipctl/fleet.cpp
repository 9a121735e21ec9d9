#include "tools/slipctl/fleet.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <optional>

#include "core/storage/unique_fd.hpp"
#include "tools/slipctl/client.hpp"
#include "tools/slipctl/fleet_state.hpp"
#include "tools/slipctl/terminal.hpp"

namespace slipctl {
namespace {

// Beside slipctl in the build tree, else where it is installed.
std::string helper() {
  const std::filesystem::path folder = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  for (const char* place : {"slipd-fleet", "../libexec/slipd/slipd-fleet"}) {
    const std::filesystem::path program = folder / place;
    if (::access(program.c_str(), X_OK) == 0) return program;
  }
  throw ClientError("fleet needs the package slipd-mqtt: apt install slipd-mqtt");
}

std::vector<char*> pointers_of(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

// slipd-fleet, whose standard output is read here. The destructor ends it.
class FleetProcess {
 public:
  explicit FleetProcess(std::vector<std::string> words) {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw ClientError("no pipe for slipd-fleet");
    out_ = UniqueFd(ends[0]);
    const UniqueFd input(ends[1]);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, input.get(), STDOUT_FILENO);
    const int failed =
        ::posix_spawn(&pid_, words.front().c_str(), &actions, nullptr, pointers_of(words).data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) throw ClientError(words.front() + " cannot be started");
  }
  ~FleetProcess() {
    if (pid_ > 0) ::kill(pid_, SIGTERM);
    wait();
  }
  FleetProcess(const FleetProcess&) = delete;
  FleetProcess& operator=(const FleetProcess&) = delete;

  int fd() const { return out_.get(); }

  // Reads what has come, without waiting after poll(). False: it has ended.
  bool read(std::vector<std::string>& lines) {
    std::array<char, 65536> bytes;
    const ssize_t count = ::read(out_.get(), bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) return true;
    if (count <= 0) return false;
    rest_.append(bytes.data(), static_cast<std::size_t>(count));
    std::size_t begin = 0;
    for (std::size_t end = rest_.find('\n'); end != std::string::npos; end = rest_.find('\n', begin)) {
      lines.push_back(rest_.substr(begin, end - begin));
      begin = end + 1;
    }
    rest_.erase(0, begin);
    return true;
  }

  // Its exit code once it has ended.
  int wait() {
    if (pid_ > 0) {
      int status = 0;
      while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
      }
      pid_ = -1;
      code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 1;
    }
    return code_;
  }

 private:
  UniqueFd out_;
  std::string rest_;
  pid_t pid_ = -1;
  int code_ = 1;
};

class FleetView {
 public:
  FleetView(const FleetOptions& options, std::vector<std::string> words)
      : options_(options), process_(std::move(words)) {}

  int run() {
    while (!over_) {
      wait();
      if (take_view_signals(signals_, terminal_).end) over_ = true;
      if (!over_ && terminal_) terminal_->show(draw());
    }
    terminal_.reset();
    if (!ended_) return 0;
    const int code = process_.wait();
    if (options_.once && code == 0) std::cout << fleet_table(state_);
    return code;
  }

 private:
  void wait() {
    pollfd wanted[] = {{process_.fd(), POLLIN, 0},
                       {signals_.fd(), POLLIN, 0},
                       {terminal_ && terminal_->has_keys() ? STDIN_FILENO : -1, POLLIN, 0}};
    if (::poll(wanted, std::size(wanted), -1) < 0) return;
    if (wanted[0].revents != 0) take_lines();
    if (wanted[2].revents != 0 && terminal_->read_keys().find_first_of("qQ") != std::string::npos)
      over_ = true;
  }

  void take_lines() {
    std::vector<std::string> lines;
    ended_ = over_ = !process_.read(lines);
    for (const std::string& line : lines) {
      const std::string gripper = take_fleet_line(state_, line);
      if (!options_.once && !on_terminal_) print(gripper);
    }
    // Not before the first line: until then slipd-fleet may refuse its arguments.
    if (!ended_ && !options_.once && on_terminal_ && !terminal_) terminal_.emplace();
    std::cout.flush();
  }

  void print(const std::string& gripper) const {
    const auto line = state_.lines.find(gripper);
    if (line != state_.lines.end())
      std::cout << fleet_text(line->second) << '\n';
    else if (!gripper.empty())
      std::cout << gripper << "  removed\n";
    else if (!state_.connected)
      std::cerr << "slipctl: no broker: " << state_.trouble << "; trying again" << std::endl;
  }

  Canvas draw() const {
    const auto [columns, rows] = terminal_->size();
    return draw_fleet(state_, columns, rows);
  }

  const FleetOptions& options_;
  FleetProcess process_;  // before the signals are blocked, which it would inherit
  SignalWatch signals_;
  FleetState state_;
  bool on_terminal_ = ::isatty(STDOUT_FILENO) == 1;
  bool over_ = false;
  bool ended_ = false;                // slipd-fleet has
  std::optional<Terminal> terminal_;  // last: restored before all else is destroyed
};

}  // namespace

int fleet(const FleetOptions& options) {
  std::vector<std::string> words{helper()};
  words.insert(words.end(), options.arguments.begin(), options.arguments.end());
  if (options.once) words.emplace_back("--once");
  if (!options.json) return FleetView(options, std::move(words)).run();
  ::execv(words.front().c_str(), pointers_of(words).data());
  throw ClientError(words.front() + " cannot be started");
}

}  // namespace slipctl
