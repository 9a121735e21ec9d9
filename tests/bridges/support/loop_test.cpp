#include "bridges/support/loop.hpp"

#include <gtest/gtest.h>
#include <sys/epoll.h>
#include <unistd.h>

#include <csignal>
#include <optional>
#include <stdexcept>

namespace slipd::bridges {
namespace {

using std::chrono::milliseconds;

struct Pipe {
  Pipe() { EXPECT_EQ(pipe(ends), 0); }
  ~Pipe() {
    close(ends[0]);
    close(ends[1]);
  }
  void fill() const { EXPECT_EQ(write(ends[1], "x", 1), 1); }
  int ends[2]{};
};

TEST(Loop, CallsTheHandlerOfADescriptorWhileItIsReadable) {
  const Pipe pipe;
  Loop loop;
  int calls = 0;
  const Loop::Watch watch(loop, pipe.ends[0], EPOLLIN, [&](std::uint32_t events) {
    EXPECT_TRUE(events & EPOLLIN);
    if (++calls == 2) loop.stop();
  });
  pipe.fill();
  loop.run();
  EXPECT_EQ(calls, 2);
}

TEST(Loop, LetsAHandlerDestroyItsOwnWatch) {
  const Pipe pipe;
  Loop loop;
  std::optional<Loop::Watch> watch;
  int calls = 0;
  watch.emplace(loop, pipe.ends[0], EPOLLIN, [&, kept = std::string(100, 'x')](std::uint32_t) {
    watch.reset();
    calls += kept.size() == 100 ? 1 : 0;  // the captures live as long as the call
  });
  pipe.fill();
  Loop::Timer end(loop, [&] { loop.stop(); });
  end.start(milliseconds(1));
  loop.run();
  EXPECT_EQ(calls, 1);
}

TEST(Loop, CallsATimerOnceForEachStart) {
  Loop loop;
  int calls = 0;
  Loop::Timer timer(loop, [&] {
    if (++calls < 3) timer.start({});
  });
  Loop::Timer never(loop, [] { FAIL(); });
  never.start(milliseconds(1));
  never.stop();
  EXPECT_FALSE(never.running());
  Loop::Timer end(loop, [&] { loop.stop(); });
  end.start(milliseconds(20));
  timer.start({});
  EXPECT_TRUE(timer.running());
  loop.run();
  EXPECT_EQ(calls, 3);
  EXPECT_FALSE(timer.running());
}

TEST(Loop, AllowsDestructorsToUseItAfterItsEnd) {
  const Pipe pipe;
  Loop loop;
  Loop::Watch watch(loop, pipe.ends[0], EPOLLIN, [](std::uint32_t) { FAIL(); });
  Loop::Timer end(loop, [&] { loop.stop(); });
  end.start({});
  loop.run();
  watch.want(EPOLLOUT);
  end.start({});
  end.stop();
}

TEST(Loop, TakesSignals) {
  Loop loop;
  int calls = 0;
  loop.on_signal(SIGUSR1, [&] {
    ++calls;
    loop.stop();
  });
  raise(SIGUSR1);
  loop.run();
  EXPECT_EQ(calls, 1);
}

TEST(Loop, ThrowsWhatAHandlerThrows) {
  Loop loop;
  Loop::Timer timer(loop, [] { throw std::runtime_error("from a handler"); });
  timer.start({});
  EXPECT_THROW(loop.run(), std::runtime_error);
}

}  // namespace
}  // namespace slipd::bridges
