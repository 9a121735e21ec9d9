// stop-thread PID NAME: stops one thread of a process, which a signal cannot do, and prints "stopped". Waits
// for the thread as long as the process lives: a thread has its name only after it began. The thread goes on
// when this program is killed: the kernel then releases what the tracer stopped.
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

namespace {

// -1: the process is gone.
pid_t thread_of(const std::string& process, const std::string& name) {
  constexpr useconds_t kBetweenLooks_us = 1000;
  for (std::error_code gone;; ::usleep(kBetweenLooks_us)) {
    for (const auto& task : std::filesystem::directory_iterator("/proc/" + process + "/task", gone)) {
      std::string here;
      std::getline(std::ifstream(task.path() / "comm"), here);
      if (here == name) return std::atoi(task.path().filename().c_str());
    }
    if (gone) return -1;
  }
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
