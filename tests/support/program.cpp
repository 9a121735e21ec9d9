#include "tests/support/program.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

namespace slipd::testing {
namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

Program::Program(const TempFolder& folder, const std::string& name, std::vector<std::string> command,
                 const Environment& environment)
    : output_(folder.file(name + ".out")), errors_(folder.file(name + ".err")) {
  std::vector<char*> arguments;
  for (auto& word : command) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("fork");
  if (pid_ > 0) return;
  const auto redirect = [](const std::filesystem::path& file, int to) {
    const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (fd >= 0) dup2(fd, to);
  };
  redirect("/dev/null", STDIN_FILENO);
  redirect(output_, STDOUT_FILENO);
  redirect(errors_, STDERR_FILENO);
  for (const auto& [key, value] : environment) setenv(key.c_str(), value.c_str(), 1);
  execv(arguments.front(), arguments.data());
  _exit(127);
}

Program::~Program() {
  if (code_ || pid_ <= 0) return;
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

void Program::signal(int number) const {
  kill(pid_, number);
}

std::optional<int> Program::wait(std::chrono::milliseconds patience) {
  if (code_) return code_;
  const int handle = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));
  pollfd ended{handle, POLLIN, 0};
  const int ready = poll(&ended, 1, static_cast<int>(patience.count()));
  close(handle);
  if (ready <= 0) return std::nullopt;
  int status = 0;
  waitpid(pid_, &status, 0);
  code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return code_;
}

std::string Program::output() const {
  return text_of(output_);
}
std::string Program::errors() const {
  return text_of(errors_);
}

std::filesystem::path program_folder() {
  return std::filesystem::path(SLIPD_BINARY_DIR) / "bin";
}

Ran run(std::vector<std::string> command, const Program::Environment& environment) {
  const TempFolder folder;
  const std::string name = command.front();
  Program program(folder, "run", std::move(command), environment);
  const auto code = program.wait();
  EXPECT_TRUE(code.has_value()) << name << " does not end";
  return {code.value_or(-1), program.output(), program.errors()};
}

}  // namespace slipd::testing
