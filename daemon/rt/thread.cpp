#include "daemon/rt/thread.hpp"

#include <algorithm>
#include <climits>
#include <csignal>
#include <system_error>
#include <utility>

namespace slipd {
namespace {

struct Body {
  std::function<void()> run;
  std::shared_ptr<Doorbell> ended;
};

extern "C" void* slipd_thread_body(void* argument) {
  const std::unique_ptr<Body> body(static_cast<Body*>(argument));
  body->run();
  body->run = nullptr;
  body->ended->ring();
  return nullptr;
}

}  // namespace

Thread::Thread(const std::string& name, std::size_t stack_bytes, std::function<void()> body)
    : ended_(std::make_shared<Doorbell>()) {
  auto owned = std::make_unique<Body>(Body{std::move(body), ended_});
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, std::max<std::size_t>(stack_bytes, PTHREAD_STACK_MIN));
  // Only io handles signals. A new thread inherits the signal mask of its creator.
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

Thread::Thread(Thread&& other) noexcept
    : id_(other.id_), joinable_(std::exchange(other.joinable_, false)), ended_(std::move(other.ended_)) {}

Thread& Thread::operator=(Thread&& other) noexcept {
  std::swap(id_, other.id_);
  std::swap(joinable_, other.joinable_);
  std::swap(ended_, other.ended_);
  return *this;
}

Thread::~Thread() {
  if (joinable_) pthread_join(id_, nullptr);
}

// On CLOCK_MONOTONIC. pthread_timedjoin_np uses CLOCK_REALTIME, which may be set meanwhile.
bool Thread::join_until(std::chrono::steady_clock::time_point deadline) {
  if (!joinable_) return true;
  joinable_ = false;
  while (ended_->ring_count() == 0 && ended_->wait(0, deadline)) {
  }
  if (ended_->ring_count() == 0) {
    pthread_detach(id_);
    return false;
  }
  pthread_join(id_, nullptr);
  return true;
}

}  // namespace slipd
