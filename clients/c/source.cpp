// The functions of slipd.h that send frames to a sensor with the driver push. docs/push.md states every byte.
#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <system_error>

#include "clients/c/client.hpp"
#include "clients/c/estimate.hpp"
#include "clients/c/frame_ring.hpp"
#include "core/storage/descriptor_passing.hpp"
#include "push_layout/layout.hpp"

using namespace slipd::client;
namespace push_layout = slipd::push_layout;

struct slipd_source {
  std::string path;  // of the sensor's socket
  push_layout::Hello hello;
  std::size_t frame_size = 0;     // bytes
  std::uint64_t sequence = 0;     // of the last frame
  slipd::UniqueFd socket;         // none: not connected
  FrameRing ring;                 // of this connection, for large frames
  std::array<char, 640> error{};  // the path, and what slipd says
};

namespace {

int note(slipd_source& s, int code, const char* text) noexcept {
  std::snprintf(s.error.data(), s.error.size(), "%s: %s", s.path.c_str(), text);
  return code;
}

int note_system_error(slipd_source& s, int error) noexcept {
  switch (error) {
    case ENOENT:
      return note(s, SLIPD_DISCONNECTED,
                  "slipd does not run here, or its configuration has no sensor with driver push there");
    case ECONNREFUSED:
      return note(s, SLIPD_DISCONNECTED, "nobody listens: slipd has stopped or is just starting");
    case EACCES:
    case EPERM:
      return note(s, SLIPD_DISCONNECTED,
                  "not permitted: become a member of the socket's group (usermod -aG GROUP USER), and log in "
                  "again");
    case EPIPE:
    case ECONNRESET:
      return note(s, SLIPD_DISCONNECTED, "slipd has closed the connection: it was stopped or restarted");
    case EAGAIN:
      return note(s, SLIPD_TIMEOUT, "slipd does not read: it hangs, or the frames come faster than rate_hz");
    default: {
      std::array<char, 128> text{};
      return note(s, SLIPD_DISCONNECTED, ::strerror_r(error, text.data(), text.size()));
    }
  }
}

int lose(slipd_source& s, int error) noexcept {
  s.socket = {};
  return note_system_error(s, error);
}

// Waits until the socket is ready for `events`; false: not in time.
bool wait_for(const slipd_source& s, short events, Clock::time_point until) noexcept {
  pollfd ready{s.socket.get(), events, 0};
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    const int got = poll(&ready, 1, static_cast<int>(std::max<std::int64_t>(0, left.count())));
    if (got > 0) return true;
    if (got == 0 || errno != EINTR) return false;
  }
}

// Sends one message of these pieces. 0, or errno.
int send_whole(const slipd_source& s, std::span<iovec> pieces, Clock::time_point until) noexcept {
  msghdr message{};
  message.msg_iov = pieces.data();
  message.msg_iovlen = pieces.size();
  while (sendmsg(s.socket.get(), &message, MSG_NOSIGNAL | MSG_DONTWAIT) < 0) {
    if (errno == EINTR) continue;
    if (errno != EAGAIN || !wait_for(s, POLLOUT, until)) return errno == EINTR ? EAGAIN : errno;
  }
  return 0;
}

// What slipd says. SLIPD_DONE: the hello is accepted.
int take_answer(slipd_source& s, Clock::time_point until) noexcept {
  std::array<char, sizeof(push_layout::Answer) + push_layout::kLongestAnswer + 1> message{};
  if (!wait_for(s, POLLIN, until)) return lose(s, EAGAIN);
  slipd::PassedDescriptors passed;
  const std::span<char> room(message.data(), message.size() - 1);
  ssize_t size = slipd::receive_passed(s.socket.get(), room, passed, MSG_DONTWAIT);
  // The error of a message that came after slipd had closed; what slipd said before is still there.
  if (size < 0 && errno == ECONNRESET)
    size = slipd::receive_passed(s.socket.get(), room, passed, MSG_DONTWAIT);
  push_layout::Answer answer{};
  if (size < static_cast<ssize_t>(sizeof answer)) return lose(s, ECONNRESET);
  std::memcpy(&answer, message.data(), sizeof answer);
  if (answer == push_layout::Answer::accepted) {
    s.ring = FrameRing(passed.files[0], s.frame_size - sizeof(push_layout::FrameHead));
    return SLIPD_DONE;
  }
  s.socket = {};
  return note(s, SLIPD_REFUSED, message.data() + sizeof answer);
}

int connect(slipd_source& s, Clock::time_point until) noexcept {
  if (s.socket) return SLIPD_DONE;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  s.path.copy(address.sun_path, sizeof address.sun_path - 1);
  s.socket = slipd::UniqueFd(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!s.socket) return lose(s, errno);
  // A frame may be longer than what a socket holds by default. The kernel doubles it for what it needs
  // itself.
  const int held = std::max(static_cast<int>(s.frame_size), 1 << 16);
  setsockopt(s.socket.get(), SOL_SOCKET, SO_SNDBUF, &held, sizeof held);
  if (::connect(s.socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return lose(s, errno);
  std::array<iovec, 1> hello{{{&s.hello, sizeof s.hello}}};
  const int error = send_whole(s, hello, until);
  if (error != 0 && error != EPIPE) return lose(s, error);  // after EPIPE the answer says why
  return take_answer(s, until);
}

bool is_possible(const slipd_frames& frames) noexcept {
  return frames.taxels > 0 && (frames.axes == 1 || frames.axes == 3) && frames.unit >= SLIPD_UNIT_UNSAID &&
         frames.unit <= SLIPD_UNIT_MM && frames.zero >= SLIPD_ZERO_UNSAID && frames.zero <= SLIPD_ZERO_ZERO &&
         frames.rate_hz >= 0 && frames.rate_hz <= std::numeric_limits<double>::max() &&
         push_layout::frame_size(frames.taxels, static_cast<std::size_t>(frames.axes)) <=
             push_layout::kLongestMessage;
}

std::string path_of(const std::string& sensor, const std::string& slipd) {
  if (sensor.find('/') != std::string::npos) return sensor;
  const std::size_t folder = slipd.rfind('/');
  return (folder == std::string::npos ? "" : slipd.substr(0, folder + 1)) + "push/" + sensor;
}

}  // namespace

int slipd_source_open(slipd_source** out, const char* sensor, const char* path,
                      const struct slipd_frames* frames) {
  if (out == nullptr) return SLIPD_INVALID;
  *out = nullptr;
  if (sensor == nullptr || frames == nullptr || !is_possible(*frames)) return SLIPD_INVALID;
  try {
    auto made = std::make_unique<slipd_source>();
    made->path = path_of(sensor, path == nullptr ? SLIPD_SOCKET : path);
    if (made->path.size() >= sizeof sockaddr_un{}.sun_path) return SLIPD_INVALID;
    made->hello = {.axes = static_cast<std::uint8_t>(frames->axes),
                   .unit = static_cast<push_layout::Unit>(frames->unit),
                   .taxels = frames->taxels,
                   .rate_hz = frames->rate_hz,
                   .zero = static_cast<push_layout::Zero>(frames->zero)};
    made->frame_size = push_layout::frame_size(frames->taxels, made->hello.axes);
    *out = made.release();
    return SLIPD_DONE;
  } catch (const std::bad_alloc&) {
    return SLIPD_NO_MEMORY;
  }
}

int slipd_source_connect(slipd_source* s, double timeout_s) {
  if (s == nullptr) return SLIPD_INVALID;
  s->error.front() = 0;
  return connect(*s, after(timeout_s));
}

int slipd_push(slipd_source* s, const float* values, int64_t time_ns, uint64_t sequence, double timeout_s) {
  if (s == nullptr || values == nullptr) return SLIPD_INVALID;
  s->error.front() = 0;
  const Clock::time_point until = after(timeout_s);
  push_layout::FrameHead head{.size = static_cast<std::uint32_t>(s->frame_size),
                              .sequence = sequence == 0 ? s->sequence + 1 : sequence,
                              .time_ns = time_ns == 0 ? monotonic_ns() : time_ns};
  if (const int code = connect(*s, until); code != SLIPD_DONE) return code;
  std::uint64_t in_ring = s->ring.put(values);
  if (in_ring != 0) {
    head.flags = push_layout::kInRing;
    head.size = sizeof(push_layout::Notice);
  }
  // sendmsg does not write to what its pieces point to.
  std::array<iovec, 2> pieces{
      {{&head, sizeof head}, {const_cast<float*>(values), s->frame_size - sizeof head}}};
  if (in_ring != 0) pieces[1] = {&in_ring, sizeof in_ring};
  const int error = send_whole(*s, pieces, until);
  if (error != 0 && in_ring != 0) s->ring.take_back();
  if (error == EPIPE || error == ECONNRESET) return take_answer(*s, Clock::now());
  if (error == EAGAIN) return note_system_error(*s, error);
  if (error != 0) return lose(*s, error);
  s->sequence = head.sequence;
  return SLIPD_DONE;
}

const char* slipd_source_error(const slipd_source* s) {
  return s == nullptr ? "" : s->error.data();
}

void slipd_source_close(slipd_source* s) {
  delete s;
}
