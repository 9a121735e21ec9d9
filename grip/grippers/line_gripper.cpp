// A gripper behind a program of the user: a JSON object a line to it, and one back. The program listens on a
// Unix socket, or is started with the lines as its input and output.
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <system_error>
#include <utility>
#include <vector>

#include "bridges/support/unix_address.hpp"
#include "grip/grippers/gripper.hpp"
#include "schema/json_text.hpp"

namespace slipd::grip {
namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::milliseconds;
// No answer is longer, bytes.
constexpr std::size_t kLongestLine = 4096;
// A program that was started has its first answer by then: an interpreter takes seconds on a busy machine.
constexpr std::chrono::seconds kStart{5};

std::string why(int error) {
  return std::generic_category().message(error);
}

std::string text_of(const Command& command) {
  static constexpr const char* kMoves[] = {"stay", "open", "grip"};
  nlohmann::json line{{"order", kMoves[static_cast<std::size_t>(command.order.move)]},
                      {"speed_mm_s", command.speed_mm_s},
                      {"sequence", command.sequence}};
  if (command.order.move == Move::grip) line["force_n"] = command.order.force_n;
  return line.dump() + "\n";
}

class LineGripper final : public Gripper {
 public:
  explicit LineGripper(const nlohmann::json& settings)
      : socket_path_(settings.value("socket", "")),
        program_(settings.value("command", std::vector<std::string>{})),
        timeout_(static_cast<std::int64_t>(settings.at("answer_ms").get<double>())),
        place_(socket_path_.empty() ? program_.front() : socket_path_) {}
  ~LineGripper() override { drop(); }
  LineGripper(const LineGripper&) = delete;
  LineGripper& operator=(const LineGripper&) = delete;

  void connect() override {
    drop();
    if (socket_path_.empty())
      start_program();
    else
      connect_socket();
  }

  std::optional<GripperFacts> obey(const Command& command) override {
    if (fd_ < 0) fail("is not connected");
    const std::string line = text_of(command);
    if (::send(fd_, line.data(), line.size(), MSG_NOSIGNAL | MSG_DONTWAIT) !=
        static_cast<ssize_t>(line.size()))
      fail("takes no orders: " + why(errno));
    const std::string said = answer(starts_ ? std::max<Milliseconds>(timeout_, kStart) : timeout_);
    starts_ = false;
    return facts_of(said);
  }

  bool wants_each() const override { return true; }

 private:
  [[noreturn]] void fail(const std::string& what) {
    drop();
    throw GripperError("gripper at " + place_ + " " + what);
  }

  void drop() noexcept {
    if (fd_ >= 0) ::close(std::exchange(fd_, -1));
    read_.clear();
    if (child_ > 0) {
      ::kill(child_, SIGKILL);
      ::waitpid(std::exchange(child_, -1), nullptr, 0);
    }
  }

  void connect_socket() {
    const auto address = bridges::unix_address(socket_path_);
    if (!address) fail("has a path that is too long for a socket");
    fd_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd_ >= 0 && ::connect(fd_, reinterpret_cast<const sockaddr*>(&*address), sizeof *address) == 0)
      return;
    if (errno == EAGAIN) fail("takes no connection: the program that listens there hangs; start it anew");
    fail("cannot be reached: " + why(errno) + "; start the program that listens there");
  }

  void start_program() {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) fail("failed: " + why(errno));
    fd_ = ends[0];
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    std::vector<char*> arguments;
    arguments.reserve(program_.size() + 1);
    for (std::string& argument : program_) arguments.push_back(argument.data());
    arguments.push_back(nullptr);
    pid_t child = -1;
    const int error = ::posix_spawnp(&child, arguments.front(), &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    if (error != 0) fail("cannot be started: " + why(error));
    child_ = child;
    starts_ = true;
  }

  // The next line, within the time-out.
  std::string answer(Milliseconds timeout) {
    const auto until = Clock::now() + timeout;
    for (;;) {
      if (const auto end = read_.find('\n'); end != std::string::npos) {
        std::string line = read_.substr(0, end);
        read_.erase(0, end + 1);
        return line;
      }
      if (read_.size() > kLongestLine) fail("sends what is no line");
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
      pollfd ready{fd_, POLLIN, 0};
      if (left <= 0 || ::poll(&ready, 1, static_cast<int>(left)) == 0)
        fail("did not answer within " + std::to_string(timeout.count()) + " ms");
      char bytes[512];
      const ssize_t got = ::recv(fd_, bytes, sizeof bytes, MSG_DONTWAIT);
      if (got == 0) fail("has gone");
      if (got < 0 && errno != EAGAIN && errno != EINTR) fail("has gone: " + why(errno));
      if (got > 0) read_.append(bytes, static_cast<std::size_t>(got));
    }
  }

  GripperFacts facts_of(const std::string& line) {
    const nlohmann::json said = nlohmann::json::parse(line, nullptr, false);
    if (!said.is_object()) fail("answered what is no JSON object: " + plain(line.substr(0, 80)));
    if (const auto fault = said.find("fault"); fault != said.end() && fault->is_string())
      throw GripperFault("gripper at " + place_ + " says: " + plain(fault->get<std::string>()));
    GripperFacts facts;
    if (const auto width = said.find("width_mm"); width != said.end() && width->is_number())
      facts.width_mm = *width;
    if (const auto force = said.find("force_n"); force != said.end() && force->is_number())
      facts.force_n = *force;
    return facts;
  }

  std::string socket_path_;
  std::vector<std::string> program_;
  Milliseconds timeout_;
  std::string place_;
  int fd_ = -1;
  pid_t child_ = -1;
  std::string read_;
  bool starts_ = false;  // the program has not answered yet
};

}  // namespace

std::unique_ptr<Gripper> make_line_gripper(const nlohmann::json& settings) {
  return std::make_unique<LineGripper>(settings);
}

}  // namespace slipd::grip
