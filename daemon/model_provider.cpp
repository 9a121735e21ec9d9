#include "daemon/model_provider.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <stdexcept>
#include <system_error>

#include "core/storage/unique_fd.hpp"
#include "core/storage/whole_file.hpp"
#include "daemon/log/log.hpp"
#include "daemon/paper_loader.hpp"

namespace slipd {
namespace {

// Nice value of the training process, 0 to 19. Smaller: training delays estimates.
constexpr int kTrainingNice = 10;
// Time between two looks at stop_, ms: the delay of a stop during training.
constexpr int kLookMs = 100;

// An anonymous file in memory that holds `text`, positioned at its start.
UniqueFd file_of(const std::string& text) {
  UniqueFd file(memfd_create("slipd-model", MFD_CLOEXEC));
  if (!file || write(file.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size()) ||
      lseek(file.get(), 0, SEEK_SET) != 0) {
    throw std::system_error(errno, std::generic_category(), "cannot pass on what to train");
  }
  return file;
}

std::vector<std::uint8_t> bytes_of(const UniqueFd& file) {
  const off_t size = lseek(file.get(), 0, SEEK_END);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(std::max<off_t>(size, 0)));
  if (size < 0 || pread(file.get(), bytes.data(), bytes.size(), 0) != size)
    throw std::system_error(errno, std::generic_category(), "cannot take over the model");
  return bytes;
}

// Starts the program with standard input, output and error, an empty signal mask and default signal handlers.
pid_t start(const std::filesystem::path& program, const UniqueFd& in, const UniqueFd& out,
            const UniqueFd& errors) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, in.get(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, out.get(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, errors.get(), STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigset_t defaults;
  sigemptyset(&none);
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  std::array<std::string, 6> words{program.string(), "train", "--setup", "-", "--model", "-"};
  std::array<char*, words.size() + 1> arguments{};  // ended by null
  std::ranges::transform(words, arguments.begin(), [](std::string& word) { return word.data(); });
  pid_t child = -1;
  const int error = posix_spawnp(&child, words[0].c_str(), &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0) {
    throw std::runtime_error("cannot start " + program.string() +
                             " to train a model: " + std::generic_category().message(error) +
                             "; install sliplab, or choose estimator.method moments");
  }
  setpriority(PRIO_PROCESS, static_cast<id_t>(child), kTrainingNice);
  return child;
}

}  // namespace

std::filesystem::path trainer_beside_program() {
  std::error_code error;
  const auto beside = std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / "sliplab";
  return !error && std::filesystem::exists(beside, error) ? beside : std::filesystem::path("sliplab");
}

std::shared_ptr<const TrainedModel> ModelProvider::get(const std::string& sensor, const ChainSetup& setup) {
  const PaperModule& paper = paper_module();
  const std::filesystem::path file = paper.cache_file(setup);
  std::weak_ptr<const TrainedModel>& known = loaded_[file];
  if (auto model = known.lock()) return model;
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored)) {
    try {
      auto model = paper.load(setup);
      known = model;
      return model;
    } catch (const std::runtime_error& error) {
      write_log(LogLevel::warning, {sensor, Cause::machine},
                sensor + ": " + error.what() + "; it is made anew");
    }
  }
  write_log(LogLevel::info, {sensor},
            sensor + ": training a model of its scene; until it is there, the sensor is learning");
  const std::vector<std::uint8_t> bytes = train(sensor, paper.training_setup(setup));
  auto model = paper.decode(bytes);
  known = model;
  try {
    write_whole_file(file, bytes);
  } catch (const std::exception& error) {
    write_log(
        LogLevel::warning, {sensor, Cause::machine},
        sensor + ": its model is used, but not kept, and is made anew with the next start: " + error.what());
  }
  return model;
}

std::vector<std::uint8_t> ModelProvider::train(const std::string& sensor, const std::string& setup_json) {
  const UniqueFd in = file_of(setup_json);
  const UniqueFd out = file_of("");
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  const UniqueFd heard(ends[0]);
  UniqueFd said(ends[1]);
  const pid_t child = start(trainer_, in, out, said);
  said = UniqueFd();
  std::string text;
  std::string last;
  bool killed = false;
  for (;;) {
    if (stop_.load(std::memory_order_relaxed) && !killed) killed = kill(child, SIGKILL) == 0;
    pollfd news{heard.get(), POLLIN, 0};
    if (poll(&news, 1, kLookMs) <= 0) continue;
    std::array<char, 1024> bytes{};
    const auto got = read(heard.get(), bytes.data(), bytes.size());
    if (got <= 0) break;
    text.append(bytes.data(), static_cast<std::size_t>(got));
    for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n')) {
      last = text.substr(0, end);
      text.erase(0, end + 1);
      write_log(LogLevel::info, {sensor}, std::string(sensor).append(": ").append(last));
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (killed) throw std::runtime_error("training was broken off: slipd is stopping");
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw std::runtime_error("training failed" + (last.empty() ? "" : ": " + last));
  }
  return bytes_of(out);
}

}  // namespace slipd
