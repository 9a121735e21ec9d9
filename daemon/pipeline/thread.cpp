#include "daemon/pipeline/thread.hpp"

#include <climits>
#include <csignal>
#include <ctime>
#include <system_error>
#include <utility>

namespace slipd {
namespace {

extern "C" void* slipd_thread_body(void* argument) {
  const std::unique_ptr<std::function<void()>> body(static_cast<std::function<void()>*>(argument));
  (*body)();
  return nullptr;
}

}  // namespace

Thread::Thread(const std::string& name, std::size_t stack_bytes, std::function<void()> body) {
  auto owned = std::make_unique<std::function<void()>>(std::move(body));
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, std::max<std::size_t>(stack_bytes, PTHREAD_STACK_MIN));
  // Signals are io's alone; a new thread takes over its maker's mask.
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const int error = pthread_create(&id_, &attributes, slipd_thread_body, owned.get());
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_attr_destroy(&attributes);
  if (error != 0) throw std::system_error(error, std::generic_category(), "starting thread " + name);
  [[maybe_unused]] const auto* taken_over = owned.release();
  joinable_ = true;
  pthread_setname_np(id_, name.substr(0, 15).c_str());
}

Thread::Thread(Thread&& other) noexcept : id_(other.id_), joinable_(std::exchange(other.joinable_, false)) {}

Thread& Thread::operator=(Thread&& other) noexcept {
  std::swap(id_, other.id_);
  std::swap(joinable_, other.joinable_);
  return *this;
}

Thread::~Thread() {
  if (joinable_) pthread_join(id_, nullptr);
}

bool Thread::join_until(std::chrono::system_clock::time_point deadline) {
  if (!joinable_) return true;
  const auto since = deadline.time_since_epoch();
  timespec until{};
  until.tv_sec = static_cast<time_t>(std::chrono::duration_cast<std::chrono::seconds>(since).count());
  until.tv_nsec = static_cast<long>(
      (std::chrono::duration_cast<std::chrono::nanoseconds>(since) % std::chrono::seconds(1)).count());
  joinable_ = false;
  if (pthread_timedjoin_np(id_, nullptr, &until) == 0) return true;
  pthread_detach(id_);
  return false;
}

}  // namespace slipd
