#include "bridges/support/loop.hpp"

#include <pthread.h>
#include <systemd/sd-event.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <exception>
#include <list>
#include <system_error>
#include <utility>

namespace slipd::bridges {

// Not in the anonymous namespace: members of Loop's structs have these types.
namespace loop_detail {
struct Release {
  void operator()(sd_event* event) const noexcept { sd_event_unref(event); }
  void operator()(sd_event_source* source) const noexcept { sd_event_source_disable_unref(source); }
};
using EventSource = std::unique_ptr<sd_event_source, Release>;
}  // namespace loop_detail

using loop_detail::EventSource;

namespace {

int succeeded(int code, const char* what) {
  if (code < 0) throw std::system_error(-code, std::generic_category(), what);
  return code;
}

// A loop that has ended serves nothing more: what destructors still ask of it is done.
void succeeded_or_ended(int code, const char* what) {
  if (code != -ESTALE) succeeded(code, what);
}

std::uint64_t microseconds_of(std::chrono::nanoseconds pause) {
  return static_cast<std::uint64_t>(
      std::max<std::int64_t>(0, std::chrono::ceil<std::chrono::microseconds>(pause).count()));
}

}  // namespace

struct Loop::State {
  std::unique_ptr<sd_event, loop_detail::Release> event;
  std::exception_ptr failure;

  // Keeps an exception from unwinding through libsystemd.
  template <typename Call>
  int guarded(Call call) noexcept {
    try {
      call();
    } catch (...) {
      failure = std::current_exception();
      sd_event_exit(event.get(), 1);
    }
    return 0;
  }
  void rethrow() {
    if (failure) std::rethrow_exception(std::exchange(failure, nullptr));
  }

  struct Signal {
    State* loop;
    std::function<void()> handler;
    EventSource source;
  };
  std::list<Signal> signals;
};

// The handler is shared with the call in progress, which may destroy the source.
struct Loop::Watch::Source {
  State* loop;
  std::shared_ptr<Ready> ready;
  EventSource source;

  static int call(sd_event_source*, int, std::uint32_t events, void* self) {
    auto& source = *static_cast<Source*>(self);
    State* const loop = source.loop;
    const std::shared_ptr<Ready> ready = source.ready;
    return loop->guarded([&] { (*ready)(events); });
  }
};

struct Loop::Timer::Source {
  State* loop;
  std::shared_ptr<std::function<void()>> due;
  EventSource source;

  static int call(sd_event_source*, std::uint64_t, void* self) {
    auto& source = *static_cast<Source*>(self);
    State* const loop = source.loop;
    const std::shared_ptr<std::function<void()>> due = source.due;
    return loop->guarded([&] { (*due)(); });
  }
};

Loop::Loop() : state_(std::make_unique<State>()) {
  sd_event* made = nullptr;
  succeeded(sd_event_new(&made), "event loop");
  state_->event.reset(made);
  feed_watchdog(true);
}

Loop::~Loop() = default;

Loop::Watch::Watch() = default;
Loop::Watch::Watch(Watch&&) noexcept = default;
Loop::Watch& Loop::Watch::operator=(Watch&&) noexcept = default;
Loop::Watch::~Watch() = default;

Loop::Watch::Watch(Loop& loop, int fd, std::uint32_t events, Ready ready)
    : source_(std::make_unique<Source>(
          Source{loop.state_.get(), std::make_shared<Ready>(std::move(ready)), nullptr})) {
  sd_event_source* made = nullptr;
  succeeded(sd_event_add_io(loop.state_->event.get(), &made, fd, events, &Source::call, source_.get()),
            "watch a descriptor");
  source_->source.reset(made);
}

void Loop::Watch::want(std::uint32_t events) {
  if (source_)
    succeeded_or_ended(sd_event_source_set_io_events(source_->source.get(), events), "watch a descriptor");
}

Loop::Timer::Timer(Loop& loop, std::function<void()> due)
    : source_(std::make_unique<Source>(
          Source{loop.state_.get(), std::make_shared<std::function<void()>>(std::move(due)), nullptr})) {
  sd_event_source* made = nullptr;
  constexpr std::uint64_t kAccuracyUs = 1000;  // 0 would mean a quarter of a second
  succeeded(sd_event_add_time(loop.state_->event.get(), &made, CLOCK_MONOTONIC, 0, kAccuracyUs, &Source::call,
                              source_.get()),
            "timer");
  source_->source.reset(made);
  stop();
}

Loop::Timer::~Timer() = default;

void Loop::Timer::start(std::chrono::nanoseconds pause) {
  succeeded_or_ended(sd_event_source_set_time_relative(source_->source.get(), microseconds_of(pause)),
                     "timer");
  succeeded_or_ended(sd_event_source_set_enabled(source_->source.get(), SD_EVENT_ONESHOT), "timer");
}

void Loop::Timer::stop() {
  succeeded_or_ended(sd_event_source_set_enabled(source_->source.get(), SD_EVENT_OFF), "timer");
}

bool Loop::Timer::running() const {
  return sd_event_source_get_enabled(source_->source.get(), nullptr) > 0;
}

void Loop::on_signal(int number, std::function<void()> handler) {
  sigset_t one;
  sigemptyset(&one);
  sigaddset(&one, number);
  succeeded(-pthread_sigmask(SIG_BLOCK, &one, nullptr), "block a signal");
  State::Signal& kept =
      state_->signals.emplace_back(State::Signal{state_.get(), std::move(handler), nullptr});
  const auto call = [](sd_event_source*, const signalfd_siginfo*, void* self) {
    auto& signal = *static_cast<State::Signal*>(self);
    return signal.loop->guarded(signal.handler);
  };
  sd_event_source* made = nullptr;
  succeeded(sd_event_add_signal(state_->event.get(), &made, number, call, &kept), "wait for a signal");
  kept.source.reset(made);
}

void Loop::feed_watchdog(bool feed) {
  succeeded(sd_event_set_watchdog(state_->event.get(), feed ? 1 : 0), "watchdog");
}

void Loop::run() {
  succeeded(sd_event_loop(state_->event.get()), "event loop");
  state_->rethrow();
}

void Loop::run_once(std::chrono::milliseconds patience) {
  succeeded(sd_event_run(state_->event.get(), microseconds_of(patience)), "event loop");
  state_->rethrow();
}

void Loop::stop() {
  succeeded(sd_event_exit(state_->event.get(), 0), "event loop");
}

}  // namespace slipd::bridges
