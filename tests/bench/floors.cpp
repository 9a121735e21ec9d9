#include "tests/bench/floors.hpp"

#include <linux/futex.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <system_error>

namespace slipd::bench {

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

namespace {

using std::chrono::milliseconds;

constexpr std::size_t kFrame = std::size_t{3} * 100 * 100;  // floats
constexpr std::size_t kFrames = 64;                         // as many as the estimators' benchmarks have
constexpr std::int64_t kPeriod_ns = 1'000'000;

std::int64_t in_ns(milliseconds time) {
  return std::chrono::nanoseconds(time).count();
}

// One thread sets it, one waits for it to change.
class Bell {
 public:
  void set(std::uint32_t value) noexcept {
    value_.store(value, std::memory_order_release);
    syscall(SYS_futex, &value_, FUTEX_WAKE_PRIVATE, 1, nullptr, nullptr, 0);
  }
  std::uint32_t await_other_than(std::uint32_t seen) const noexcept {
    for (;;) {
      const std::uint32_t value = value_.load(std::memory_order_acquire);
      if (value != seen) return value;
      syscall(SYS_futex, &value_, FUTEX_WAIT_PRIVATE, seen, nullptr, nullptr, 0);
    }
  }

 private:
  std::atomic<std::uint32_t> value_{0};
};

constexpr std::uint32_t kEnd = ~0U;

// Frames of their own memory, and a place to copy one into.
struct Memory {
  std::vector<float> frames = std::vector<float>(kFrames * kFrame, 1.0F), slot = std::vector<float>(kFrame),
                     taken = std::vector<float>(kFrame);
  void fill_slot(std::size_t number) {
    std::memcpy(slot.data(), frames.data() + kFrame * (number % kFrames), kFrame * sizeof(float));
  }
  void take_slot() { std::memcpy(taken.data(), slot.data(), kFrame * sizeof(float)); }
};

// Times of `there`, then a wake, `here` in the other thread, and a wake back.
template <typename There, typename Here>
std::vector<std::int64_t> turns(milliseconds long_enough, There there, Here here) {
  Bell out, back;
  std::thread other([&] {
    for (std::uint32_t seen = 0; (seen = out.await_other_than(seen)) != kEnd;) {
      here();
      back.set(seen);
    }
  });
  std::vector<std::int64_t> times;
  times.reserve(1U << 20U);
  const std::int64_t until = now_ns() + in_ns(long_enough);
  std::int64_t since = now_ns();
  for (std::uint32_t number = 1; since < until; ++number) {
    there(number);
    out.set(number);
    back.await_other_than(number - 1);
    const std::int64_t now = now_ns();
    if (times.size() < times.capacity()) times.push_back(now - since);
    since = now;
  }
  out.set(kEnd);
  other.join();
  return times;
}

// Waits for the clock before each call of `step`, until the time is over.
template <typename Step>
void at_1_khz(milliseconds long_enough, Step step) {
  const std::int64_t begun = now_ns(), until = begun + in_ns(long_enough);
  for (std::int64_t due = begun + kPeriod_ns; due < until; due += kPeriod_ns) {
    const timespec when{due / 1'000'000'000, due % 1'000'000'000};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &when, nullptr);
    step();
  }
}

// What the third thread sends: as long as an estimate.
struct Line {
  std::int64_t stamp_ns = 0;  // 0: the last
  std::array<char, 292> rest{};
};

std::vector<std::int64_t> receive(int socket) {
  std::vector<std::int64_t> times;
  times.reserve(1U << 16U);
  for (Line line; recv(socket, &line, sizeof line, MSG_WAITALL) == sizeof line && line.stamp_ns != 0;)
    times.push_back(now_ns() - line.stamp_ns);
  return times;
}

// What watches `wake` and sends what was stamped last.
void send_stamps(int wake, int socket, const std::atomic<std::int64_t>& stamp) {
  const int events = epoll_create1(EPOLL_CLOEXEC);
  epoll_event wanted{EPOLLIN, {.fd = wake}}, ready{};
  epoll_ctl(events, EPOLL_CTL_ADD, wake, &wanted);
  for (Line line{.stamp_ns = 1}; line.stamp_ns != 0;) {
    epoll_wait(events, &ready, 1, -1);
    std::uint64_t count = 0;
    if (read(wake, &count, sizeof count) != sizeof count) break;
    line.stamp_ns = stamp.load(std::memory_order_acquire);
    if (send(socket, &line, sizeof line, MSG_NOSIGNAL) != sizeof line) break;
  }
  close(events);
}

double cpu_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto in_s = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return in_s(usage.ru_utime) + in_s(usage.ru_stime);
}

}  // namespace

Quantiles futex_wake(milliseconds long_enough) {
  auto times = turns(
      long_enough, [](std::uint32_t) {}, [] {});
  for (auto& time : times) time /= 2;
  return quantiles_of(std::move(times));
}

Quantiles frame_there_and_back(milliseconds long_enough) {
  Memory memory;
  return quantiles_of(turns(
      long_enough, [&](std::uint32_t number) { memory.fill_slot(number); }, [&] { memory.take_slot(); }));
}

Quantiles frame_to_client(milliseconds long_enough) {
  std::array<int, 2> sockets{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets.data()) < 0) fail("socketpair");
  const int wake = eventfd(0, EFD_CLOEXEC);
  if (wake < 0) fail("eventfd");
  Memory memory;
  Bell bell;
  std::atomic<std::int64_t> complete{0}, estimated{0};
  std::vector<std::int64_t> times;
  std::thread client([&] { times = receive(sockets[1]); });
  std::thread io([&] { send_stamps(wake, sockets[0], estimated); });
  std::thread estimate([&] {
    for (std::uint32_t seen = 0; seen != kEnd;) {
      seen = bell.await_other_than(seen);
      memory.take_slot();
      estimated.store(complete.load(std::memory_order_acquire), std::memory_order_release);
      eventfd_write(wake, 1);
    }
  });
  std::uint32_t number = 0;
  at_1_khz(long_enough, [&] {
    memory.fill_slot(++number);
    complete.store(now_ns(), std::memory_order_release);
    bell.set(number);
  });
  complete.store(0, std::memory_order_release);
  bell.set(kEnd);
  for (std::thread* each : {&estimate, &io, &client}) each->join();
  for (const int fd : {sockets[0], sockets[1], wake}) close(fd);
  return quantiles_of(std::move(times));
}

double two_threads_at_1_khz(milliseconds long_enough) {
  Bell bell;
  std::thread woken([&] {
    for (std::uint32_t seen = 0; seen != kEnd;) seen = bell.await_other_than(seen);
  });
  const double before_s = cpu_s();
  const std::int64_t begun = now_ns();
  std::uint32_t number = 0;
  at_1_khz(long_enough, [&] { bell.set(++number); });
  const double share = (cpu_s() - before_s) / (1e-9 * static_cast<double>(now_ns() - begun));
  bell.set(kEnd);
  woken.join();
  return share;
}

EchoServer::EchoServer(const std::filesystem::path& socket, std::size_t answer_bytes)
    : answer_(answer_bytes - 1, 'x') {
  answer_ += '\n';
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, socket.c_str(), sizeof address.sun_path - 1);
  listening_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (listening_ < 0 || bind(listening_, reinterpret_cast<const sockaddr*>(&address), sizeof address) < 0 ||
      listen(listening_, 512) < 0)
    fail("echo server");
  stop_ = eventfd(0, EFD_CLOEXEC);
  events_ = epoll_create1(EPOLL_CLOEXEC);
  for (const int fd : {listening_, stop_}) {
    epoll_event wanted{EPOLLIN, {.fd = fd}};
    epoll_ctl(events_, EPOLL_CTL_ADD, fd, &wanted);
  }
  thread_ = std::thread([this] { serve(); });
}

EchoServer::~EchoServer() {
  eventfd_write(stop_, 1);
  thread_.join();
  for (const int fd : {listening_, stop_, events_}) close(fd);
}

void EchoServer::serve() const {
  std::array<epoll_event, 256> ready{};
  std::array<char, 4096> request{};
  for (;;) {
    const int count = epoll_wait(events_, ready.data(), ready.size(), -1);
    for (int i = 0; i < count; ++i) {
      const int fd = ready[static_cast<std::size_t>(i)].data.fd;
      if (fd == stop_) return;
      if (fd == listening_) {
        const int client = accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC);
        epoll_event wanted{EPOLLIN, {.fd = client}};
        epoll_ctl(events_, EPOLL_CTL_ADD, client, &wanted);
      } else if (recv(fd, request.data(), request.size(), 0) <= 0 ||
                 send(fd, answer_.data(), answer_.size(), MSG_NOSIGNAL) < 0) {
        close(fd);
      }
    }
  }
}

}  // namespace slipd::bench
