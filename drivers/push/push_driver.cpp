#include "drivers/push/push_driver.hpp"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "core/storage/descriptor_passing.hpp"
#include "drivers/pacing.hpp"

namespace slipd::push {
namespace {

using push_layout::Answer;

constexpr std::int64_t kNsPerSecond = 1'000'000'000;
// Without a message for this long, and for four periods of the frames, a writer counts as silent. Shorter: a
// program that pauses loses its place to a second one. Longer: the next writer waits for one that hangs.
constexpr std::int64_t kPatienceNs = kNsPerSecond;
constexpr std::int64_t kPatiencePeriods = 4;
// How long a connection may take for its hello; others wait meanwhile.
constexpr std::int64_t kHelloPatienceNs = kNsPerSecond / 4;
// Between connections, so that a program that connects again and again takes no processor from others.
constexpr std::int64_t kAdmissionPeriodNs = kNsPerSecond / 100;
// Messages are read at up to this multiple of the configured rate, so that a program that never waits does
// not take a processor from others. Its frames are then too old.
constexpr std::int64_t kMostRates = 2;
// Time for which a writer may save up messages, for bursts after a pause; and in periods of the frames.
constexpr std::int64_t kBurstNs = kNsPerSecond / 10;
constexpr std::int64_t kBurstPeriods = 16;
constexpr int kMostLeftUnread = 16;  // messages of one who is turned away

void tell(int socket, Answer answer, const char* text) noexcept {
  std::array<char, sizeof answer + push_layout::kLongestAnswer> message{};
  const std::size_t length = std::min(std::strlen(text), push_layout::kLongestAnswer);
  std::memcpy(message.data(), &answer, sizeof answer);
  std::memcpy(message.data() + sizeof answer, text, length);
  (void)::send(socket, message.data(), sizeof answer + length, MSG_DONTWAIT | MSG_NOSIGNAL);
}

// Says why, and closes. What it has sent is read before, or the kernel would tell it of a reset connection
// and not of the reason.
void turn_away(UniqueFd& peer, Answer answer, const char* text) noexcept {
  ::shutdown(peer.get(), SHUT_RD);
  char byte = 0;
  for (int i = 0; i < kMostLeftUnread; ++i)
    if (::recv(peer.get(), &byte, 1, MSG_DONTWAIT) <= 0) break;
  tell(peer.get(), answer, text);
  peer = UniqueFd();
}

// 0: unknown.
int process_of(int peer) noexcept {
  ucred who{};
  socklen_t length = sizeof who;
  return ::getsockopt(peer, SOL_SOCKET, SO_PEERCRED, &who, &length) == 0 ? who.pid : 0;
}

bool is_over(ssize_t received) noexcept {
  return received == 0 || (received < 0 && errno != EAGAIN && errno != EINTR);
}

const SensorSetup& only_one(const std::vector<SensorSetup>& sensors) {
  if (sensors.size() == 1) return sensors.front();
  throw DriverError("sensor \"" + sensors.front().name +
                    "\": push has a socket for each sensor: leave out device");
}

}  // namespace

PushDriver::PushDriver(const std::vector<SensorSetup>& sensors)
    : setup_(only_one(sensors)),
      options_(parse_options(setup_)),
      period_ns_(static_cast<std::int64_t>(static_cast<double>(kNsPerSecond) / setup_.rate_hz)),
      patience_ns_(std::max(kPatienceNs, kPatiencePeriods * period_ns_)),
      agreed_(agreement_without_hello(options_, setup_)),
      message_(push_layout::frame_size(setup_.layout.size(), 3) + 1),
      reader_(options_.max_age_ns) {}

DeviceInfo PushDriver::open() {
  if (reopening_) {
    reopening_ = false;
    tell_accepted();
  } else {
    close();
    socket_ = PushSocket(options_.path, options_.mode, options_.owner, options_.group);
    frame_ns_ = monotonic_ns() - patience_ns_;
  }
  announced_ = agreed_;
  return {.description = "frames of a program at " + options_.path.string(),
          .serial = "",
          .simulated = false,
          .sensors = {{.sensor_class = agreed_.sensor_class(),
                       .layout = setup_.layout,
                       .rate_hz = setup_.rate_hz,
                       .zeroed = agreed_.zeroed,
                       .calibrated = agreed_.calibrated}}};
}

void PushDriver::close() noexcept {
  if (reopening_) return;
  candidate_ = {};
  writer_ = {};
  ring_ = FrameRing();
  socket_ = PushSocket();
}

// Waits for something to read. A writer that is ahead of its rate is left alone, and so are connections for a
// moment after each.
PushDriver::Ready PushDriver::wait(std::int64_t give_up_ns) const noexcept {
  const std::int64_t ahead_until_ns = allowance_ns_ - std::max(kBurstNs, kBurstPeriods * period_ns_);
  for (;;) {
    const std::int64_t now_ns = monotonic_ns();
    const bool ahead = now_ns < ahead_until_ns;
    const bool admits = !candidate_.socket && now_ns >= admits_from_ns_;
    std::int64_t until_ns = give_up_ns;
    if (ahead) until_ns = std::min(until_ns, ahead_until_ns);
    if (!candidate_.socket && !admits) until_ns = std::min(until_ns, admits_from_ns_);
    const std::int64_t left_ns = std::max<std::int64_t>(0, until_ns - now_ns);
    const timespec left{static_cast<time_t>(left_ns / kNsPerSecond),
                        static_cast<long>(left_ns % kNsPerSecond)};
    std::array<pollfd, 3> waited{{{admits ? socket_.get() : -1, POLLIN, 0},
                                  {candidate_.socket.get(), POLLIN, 0},
                                  {writer_.socket.get(), static_cast<short>(ahead ? 0 : POLLIN), 0}}};
    if (::ppoll(waited.data(), waited.size(), &left, nullptr) > 0)
      return {waited[0].revents != 0, waited[1].revents != 0, waited[2].revents != 0,
              (waited[2].revents & POLLHUP) != 0};
    if (monotonic_ns() >= give_up_ns) return {};
  }
}

ReadResult PushDriver::read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept {
  const std::int64_t give_up_ns = monotonic_ns() + std::chrono::nanoseconds(timeout).count();
  for (;;) {
    const Ready ready = wait(give_up_ns);
    if (ready.hung_up) {
      writer_.hung_up = true;
      allowance_ns_ = 0;  // what it has left is all that will come
    }
    if (ready.connection) admit();
    if (ready.candidate && hear_candidate()) return {ReadStatus::changed, 0};
    if (ready.writer) {
      const ReadResult result = hear_writer(slots[0]);
      if (result.status != ReadStatus::timeout) return result;
    }
    const std::int64_t now_ns = monotonic_ns();
    if (candidate_.socket && now_ns - candidate_.heard_ns > kHelloPatienceNs)
      turn_away(candidate_.socket, Answer::refused, "there was no hello in time: docs/push.md");
    if (now_ns >= give_up_ns) return {is_away() ? ReadStatus::away : ReadStatus::timeout, 0};
  }
}

void PushDriver::admit() noexcept {
  UniqueFd peer(::accept4(socket_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  const std::int64_t now_ns = monotonic_ns();
  admits_from_ns_ = now_ns + kAdmissionPeriodNs;
  if (!peer) return;
  if (writer_.socket && !writer_.hung_up && now_ns - writer_.heard_ns <= patience_ns_) {
    Text text{};
    std::snprintf(text.data(), text.size(),
                  "%s: another program (process %d) sends its frames; end that one first",
                  setup_.name.c_str(), process_of(writer_.socket.get()));
    return turn_away(peer, Answer::busy, text.data());
  }
  candidate_ = {std::move(peer), now_ns};
}

bool PushDriver::hear_candidate() noexcept {
  const ssize_t size = ::recv(candidate_.socket.get(), message_.data(), message_.size(), MSG_DONTWAIT);
  if (size <= 0) {
    if (is_over(size)) candidate_ = {};
    return false;
  }
  Agreement agreed;
  if (!agree(std::span(message_).first(static_cast<std::size_t>(size)), options_, setup_, agreed, refused_)) {
    turn_away(candidate_.socket, Answer::refused, refused_.data());
    return false;
  }
  accept_candidate(agreed);
  reopening_ = is_of_another_kind();
  if (!reopening_) tell_accepted();
  return reopening_;
}

void PushDriver::accept_candidate(const Agreement& agreed) noexcept {
  if (writer_.socket)
    turn_away(
        writer_.socket, Answer::replaced,
        "this program had sent nothing for a while, and another one sends the frames now: connect again");
  const std::int64_t now_ns = monotonic_ns();
  writer_ = {std::move(candidate_.socket), now_ns};
  candidate_ = {};
  ring_ = FrameRing();
  agreed_ = agreed;
  reader_.begin(agreed);
  allowance_ns_ = now_ns;
  refused_.front() = 0;
  last_refusal_ = Refusal::none;
}

void PushDriver::tell_accepted() noexcept {
  const std::size_t values_bytes = agreed_.taxels * agreed_.axes * sizeof(float);
  ring_ = values_bytes < push_layout::kSmallestInRing ? FrameRing() : FrameRing(values_bytes);
  const Answer accepted = Answer::accepted;
  std::array<char, sizeof accepted> message{};
  std::memcpy(message.data(), &accepted, sizeof accepted);
  (void)send_passing(writer_.socket.get(), {message.data(), message.size()}, ring_.descriptor(),
                     MSG_DONTWAIT | MSG_NOSIGNAL);
  ring_.close_descriptor();
}

bool PushDriver::is_of_another_kind() const noexcept {
  return agreed_.sensor_class() != announced_.sensor_class() || agreed_.zeroed != announced_.zeroed ||
         agreed_.calibrated != announced_.calibrated;
}

ReadResult PushDriver::hear_writer(FrameSlot& slot) noexcept {
  const ssize_t size = ::recv(writer_.socket.get(), message_.data(), message_.size(), MSG_DONTWAIT);
  const std::int64_t now_ns = monotonic_ns();  // before anything is decoded
  if (size <= 0) {
    if (is_over(size)) writer_ = {};
    return {ReadStatus::timeout, 0};
  }
  char byte = 0;
  const bool waiting = ::recv(writer_.socket.get(), &byte, 1, MSG_PEEK | MSG_DONTWAIT) > 0;
  writer_.heard_ns = now_ns;
  allowance_ns_ = std::max(allowance_ns_, now_ns) + period_ns_ / kMostRates;
  const auto message = std::span(message_).first(static_cast<std::size_t>(size));
  const bool in_ring = ring_ && message.size() == sizeof(push_layout::Notice);
  last_refusal_ = in_ring ? reader_.take_from_ring(message, ring_, now_ns, waiting, slot)
                          : reader_.take(message, now_ns, waiting, slot);
  if (last_refusal_ != Refusal::none) return {ReadStatus::corrupt, 0};
  frame_ns_ = now_ns;
  return {ReadStatus::frame, 0};
}

// A writer that has died is away once a next one has had time to come.
bool PushDriver::is_away() const noexcept {
  return monotonic_ns() - frame_ns_ > patience_ns_;
}

std::string PushDriver::why_no_frames() const {
  const std::string path = options_.path.string();
  if (writer_.socket) {
    const std::string who = "the program that is connected to " + path + " (process " +
                            std::to_string(process_of(writer_.socket.get())) + ") ";
    if (last_refusal_ == Refusal::none) return who + "sends nothing";
    return who + "sends no usable frame: the last message " + describe(last_refusal_);
  }
  if (refused_.front() != 0)
    return std::string("the program at ") + path + " was refused: " + refused_.data();
  return "no program is connected to " + path + ": start the one that sends the frames (docs/push.md)";
}

}  // namespace slipd::push
