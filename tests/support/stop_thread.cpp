// stop-thread PID NAME: stops one thread of a process, which a signal cannot do, and prints "stopped". The
// thread goes on when this program is killed: the kernel then releases what the tracer stopped.
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace {

pid_t thread_of(const std::string& process, const std::string& name) {
  for (const auto& task : std::filesystem::directory_iterator("/proc/" + process + "/task")) {
    std::string here;
    std::getline(std::ifstream(task.path() / "comm"), here);
    if (here == name) return std::atoi(task.path().filename().c_str());
  }
  return -1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const pid_t thread = thread_of(argv[1], argv[2]);
  if (thread < 0 || ptrace(PTRACE_SEIZE, thread, nullptr, nullptr) != 0 ||
      ptrace(PTRACE_INTERRUPT, thread, nullptr, nullptr) != 0 || waitpid(thread, nullptr, __WALL) != thread) {
    std::perror(argv[2]);
    return 1;
  }
  std::puts("stopped");
  std::fflush(stdout);
  for (;;) pause();
}
