// The event loop of a bridge: descriptors, timers and signals in one thread, by sd-event of libsystemd, which
// takes signals by signalfd and feeds systemd's watchdog. One thread's own.
//
// A handler may destroy its own Watch or Timer. After stop() watches and timers call no handler, and changes
// of them do nothing. An exception from a handler ends run(), which throws it again.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>

struct sd_event;

namespace slipd::bridges {

class Loop {
 public:
  // Gets the events of epoll(7) that have come.
  using Ready = std::function<void(std::uint32_t events)>;

  // Throws std::system_error.
  Loop();
  ~Loop();
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  // A descriptor that is watched until this object is destroyed, which must be before the descriptor is
  // closed.
  class Watch {
   public:
    // Watches nothing.
    Watch();
    // `events`: EPOLLIN, EPOLLOUT, … as in epoll(7), level-triggered. Throws std::system_error.
    Watch(Loop& loop, int fd, std::uint32_t events, Ready ready);
    Watch(Watch&&) noexcept;
    Watch& operator=(Watch&&) noexcept;
    ~Watch();
    // Waits for other events from now on.
    void want(std::uint32_t events);

   private:
    struct Source;
    std::unique_ptr<Source> source_;
  };

  // Calls its handler once for each start.
  class Timer {
   public:
    Timer(Loop& loop, std::function<void()> due);
    Timer(Timer&&) = delete;
    ~Timer();
    // Calls the handler once after `pause`, of CLOCK_MONOTONIC. A time that was started before is given up.
    void start(std::chrono::nanoseconds pause);
    void stop();
    bool running() const;

   private:
    struct Source;
    std::unique_ptr<Source> source_;
  };

  // Calls `handler` for each signal of this number. The signal is blocked in this thread and those that it
  // starts later, so call it before any thread is started.
  void on_signal(int number, std::function<void()> handler);

  // Whether run() feeds systemd's watchdog, which it does from the start where WatchdogSec= asks for it. For
  // a program that has to know of more than this thread. Throws std::system_error.
  void feed_watchdog(bool feed);

  // Serves until stop(). Throws what a handler throws.
  void run();
  // Serves what has come, and waits for it at most `patience`. For tests. Throws what a handler throws.
  void run_once(std::chrono::milliseconds patience);
  // Ends run() after the present handler.
  void stop();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace slipd::bridges
