#include "lab/grip/programs.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "bridges/support/clock.hpp"
#include "bridges/support/line_socket.hpp"
#include "bridges/support/unix_address.hpp"

namespace lab::grip {
namespace {

using Clock = std::chrono::steady_clock;
using nlohmann::json;

// What a program that works takes on the slowest machine.
constexpr std::chrono::seconds kPatience{60};
constexpr double kMostAgeMs = 10000;  // of a frame, where the machine is slow

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error(what);
}

void write(const std::filesystem::path& file, const json& content) {
  std::ofstream(file) << content.dump(1) << "\n";
}

json sensor(const char* name, const BedOptions& o) {
  return {{"name", name},
          {"driver", "push"},
          {"rate_hz", o.rate_hz},
          {"layout", {{"grid", {o.side, o.side}}, {"pitch_mm", o.pitch_m * 1000}}},
          {"skin",
           {{"radius_mm", o.dome_radius_m > 0 ? json(o.dome_radius_m * 1000) : json("flat")},
            {"modulus_mpa", 1},
            {"poisson", 0.45},
            {"base", "pillars"}}},
          {"options", {{"unit", "N"}, {"zeroed", true}, {"max_age_ms", kMostAgeMs}}},
          {"stale_after_ms", 10000}};
}

}  // namespace

Process::Process(const std::vector<std::string>& command, const std::filesystem::path& errors) {
  std::vector<char*> arguments;
  arguments.reserve(command.size() + 1);
  for (const std::string& one : command) arguments.push_back(const_cast<char*>(one.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, errors.c_str(), O_WRONLY | O_CREAT | O_APPEND,
                                   0644);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  const int error = ::posix_spawn(&pid_, arguments.front(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) fail(command.front() + ": " + std::generic_category().message(error));
}

void Process::kill() noexcept {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(std::exchange(pid_, -1), nullptr, 0);
}

void Process::stop() const noexcept {
  ::kill(pid_, SIGSTOP);
}

void Process::go_on() const noexcept {
  ::kill(pid_, SIGCONT);
}

Bed::Bed(const BedOptions& options) : options_(options) {
  std::string name = (std::filesystem::temp_directory_path() / "slipd-lab-grip-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) fail(name + ": " + std::generic_category().message(errno));
  folder_ = name;
  write_settings();
  const auto address = slipd::bridges::unix_address((folder_ / "gripper.sock").string()).value();
  listener_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(listener_, 4) != 0)
    fail("the gripper's socket: " + std::generic_category().message(errno));
  restart_slipd();
  restart_grip();
}

Bed::~Bed() {
  if (!options_.keep.empty()) {
    std::error_code ignored;
    std::filesystem::create_directories(options_.keep, ignored);
    for (const char* const log : {"slipd.log", "grip.log"})
      std::filesystem::copy_file(folder_ / log, options_.keep / log,
                                 std::filesystem::copy_options::overwrite_existing, ignored);
  }
  grip_.reset();
  slipd_.reset();
  if (peer_ >= 0) ::close(peer_);
  ::close(listener_);
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void Bed::write_settings() const {
  const BedOptions& o = options_;
  const double x = o.half_width_m * 1000;
  write(folder_ / "slipd.json",
        {{"sensors", {sensor("left", o), sensor("right", o)}},
         {"grasps",
          {{{"name", "gripper"},
            {"sensors", {"left", "right"}},
            {"poses",
             {{{"at_mm", {-x, 0, 0}}, {"normal", {1, 0, 0}}, {"x", {0, 1, 0}}},
              {{"at_mm", {x, 0, 0}}, {"normal", {-1, 0, 0}}, {"x", {0, -1, 0}}}}}}}},
         {"objects",
          {{{"normal_n", {0.5, o.most_n}},
            {"friction", {0.2, 1.1}},
            {"flat_share", 0.5},
            {"radius_mm", {10, 50}}}}},
         {"estimator", {{"sigma_max", 0.35}}},
         {"alerts", {{"target_margin", o.target_margin}, {"warn_below", 0.25}, {"slip_below", 0.12}}},
         {"realtime", {{"mode", "off"}, {"lock_memory", false}}},
         {"socket", {{"path", (folder_ / "slipd.sock").string()}}}});
  write(folder_ / "grip.json", {{"socket", (folder_ / "slipd.sock").string()},
                                {"fingers", {"left", "right"}},
                                {"grasp", "gripper"},
                                {"max_age_ms", kMostAgeMs},
                                {"target_margin", o.target_margin},
                                {"firm_by", o.firm_by_low ? "gamma_low" : "firm_n"},
                                {"force",
                                 {{"close_n", 2},
                                  {"least_n", 0.5},
                                  {"firm_n", o.firm_n},
                                  {"most_n", o.most_n},
                                  {"resolution_n", o.resolution_n},
                                  {"lower_per_s", 3}}},
                                {"orders", (folder_ / "orders.sock").string()},
                                {"gripper",
                                 {{"type", "line"},
                                  {"socket", (folder_ / "gripper.sock").string()},
                                  {"delay_ms", o.delay_s * 1000},
                                  {"answer_ms", 60000}}}});
}

void Bed::restart_slipd() {
  slipd_.reset();
  const std::string program = (options_.programs / "slipd").string();
  slipd_ = std::make_unique<Process>(
      std::vector<std::string>{program, "--config", (folder_ / "slipd.json").string(), "--driver-dir",
                               options_.modules.string()},
      folder_ / "slipd.log");
  const std::string socket = (folder_ / "slipd.sock").string();
  const slipd_frames frames{.taxels = static_cast<std::uint32_t>(options_.side * options_.side),
                            .axes = 3,
                            .unit = SLIPD_UNIT_N,
                            .zero = SLIPD_ZERO_ZERO,
                            .rate_hz = options_.rate_hz};
  left_ = std::make_unique<slipd::client::Source>("left", frames, socket);
  right_ = std::make_unique<slipd::client::Source>("right", frames, socket);
  const auto until = Clock::now() + kPatience;
  for (;;) {
    try {
      left_->connect();
      right_->connect();
      board_ = slipd::client::Connection(socket);
      board_.attach();
      break;
    } catch (const slipd::client::Error& error) {
      if (Clock::now() > until) fail(std::string("slipd does not serve: ") + error.what());
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  time_ns_ = slipd::bridges::monotonic_ns();
  frames_ = 0;
}

void Bed::restart_grip() {
  grip_.reset();
  drop_gripper();
  grip_ = std::make_unique<Process>(std::vector<std::string>{(options_.programs / "slipd-grip").string(),
                                                             "--config", (folder_ / "grip.json").string()},
                                    folder_ / "grip.log");
  await_connection();
}

void Bed::await_connection() {
  pollfd waits{listener_, POLLIN, 0};
  if (::poll(&waits, 1, static_cast<int>(std::chrono::milliseconds(kPatience).count())) != 1)
    fail("slipd-grip does not reach its gripper: " + grip_log());
  peer_ = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
  read_.clear();
}

void Bed::drop_gripper() {
  if (peer_ >= 0) ::close(std::exchange(peer_, -1));
}

void Bed::push_one(slipd::client::Source& source, const std::vector<float>& values, std::int64_t time_ns) {
  source.push(values, time_ns, frames_, std::chrono::duration<double>(kPatience).count());
}

// The time of the next frame is the physics', which the machine's waits for. A machine that is too slow for
// slipd's limit on a frame's age stretches time.
void Bed::advance() {
  ++frames_;
  const auto oldest_ns = slipd::bridges::monotonic_ns() - static_cast<std::int64_t>(0.5e6 * kMostAgeMs);
  time_ns_ = std::max(time_ns_ + static_cast<std::int64_t>(1e9 / options_.rate_hz), oldest_ns);
  std::this_thread::sleep_until(Clock::time_point(std::chrono::nanoseconds(time_ns_)));
}

bool Bed::push(const std::vector<float>& left, const std::vector<float>& right) {
  advance();
  try {
    push_one(*left_, left, time_ns_);
    push_one(*right_, right, time_ns_);
    return true;
  } catch (const slipd::client::Error&) {
    return false;
  }
}

Ordered Bed::exchange(const std::vector<float>& left, const std::vector<float>& right, double width_m) {
  advance();
  push_one(*left_, left, time_ns_);
  if (frames_ > 1) await(2 * frames_ - 1, width_m);
  push_one(*right_, right, time_ns_);
  return await(2 * frames_, width_m);
}

Ordered Bed::await(std::uint64_t sequence, double width_m) {
  const auto until = Clock::now() + kPatience;
  while (ordered_.sequence < sequence)
    if (!read_order(until, width_m))
      fail("slipd-grip does not answer frame " + std::to_string(sequence) + ": " + grip_log());
  return ordered_;
}

Ordered Bed::hear(std::chrono::milliseconds patience, double width_m) {
  const auto until = Clock::now() + patience;
  while (read_order(until, width_m)) {
  }
  return ordered_;
}

// Takes a line and answers it. False: none until then.
bool Bed::read_order(Clock::time_point until, double width_m) {
  for (std::size_t end = read_.find('\n'); end == std::string::npos; end = read_.find('\n')) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    pollfd waits{peer_ >= 0 ? peer_ : listener_, POLLIN, 0};
    if (left <= 0 || ::poll(&waits, 1, static_cast<int>(left)) != 1) return false;
    if (peer_ < 0) {
      await_connection();
      continue;
    }
    char bytes[1024];
    const ssize_t got = ::recv(peer_, bytes, sizeof bytes, 0);
    if (got <= 0) {
      drop_gripper();
      continue;
    }
    read_.append(bytes, static_cast<std::size_t>(got));
  }
  const std::size_t end = read_.find('\n');
  const json line = json::parse(read_.substr(0, end));
  read_.erase(0, end + 1);
  ordered_ = {line.at("order"), line.value("force_n", 0.0), line.at("sequence")};
  const std::string answer = json{{"width_mm", width_m * 1000}}.dump() + "\n";
  (void)::send(peer_, answer.data(), answer.size(), MSG_NOSIGNAL);
  return true;
}

slipd_estimate Bed::estimate() {
  return board_.latest("gripper", kMostAgeMs / 1000).fields();
}

void Bed::order(const std::string& word) {
  const auto until = Clock::now() + kPatience;
  for (;;) {
    try {
      slipd::bridges::ask((folder_ / "orders.sock").string(), word);
      return;
    } catch (const std::runtime_error&) {
      if (Clock::now() > until) fail("slipd-grip takes no orders: " + grip_log());
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
}

std::string Bed::grip_log() const {
  std::ostringstream text;
  text << std::ifstream(folder_ / "grip.log").rdbuf();
  return text.str();
}

}  // namespace lab::grip
