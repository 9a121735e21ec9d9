#include "drivers/serial/serial_transport.hpp"

#include <algorithm>
#include <limits>

#include "drivers/pacing.hpp"

namespace slipd::serial {
namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

}  // namespace

Poller::Poller(const std::vector<decode::SerialRequest>& requests, double rate_hz)
    : requests_(requests), period_ns_(static_cast<std::int64_t>(1e9 / rate_hz)) {}

const decode::SerialRequest* Poller::due(std::int64_t now_ns) const noexcept {
  if (requests_.empty() || waits_ || (next_ == 0 && now_ns < round_ns_)) return nullptr;
  return &requests_[next_];
}

std::int64_t Poller::look_again_ns() const noexcept {
  return requests_.empty() ? kNever : waits_ ? answer_by_ns_ : round_ns_;
}

void Poller::sent(std::int64_t now_ns) noexcept {
  if (next_ == 0) round_ns_ = now_ns;
  waits_ = true;
  answer_by_ns_ = now_ns + requests_[next_].answer_within_ns;
}

void Poller::answered() noexcept {
  if (!waits_) return;
  waits_ = false;
  if (++next_ == requests_.size()) end_round();
}

bool Poller::expire(std::int64_t now_ns) noexcept {
  if (!waits_ || now_ns < answer_by_ns_) return false;
  waits_ = false;
  end_round();
  return true;
}

void Poller::end_round() noexcept {
  next_ = 0;
  round_ns_ += period_ns_;
}

SerialTransport::SerialTransport(const std::string& path, const decode::Profile& profile,
                                 const decode::SerialLine& line)
    : line_(line),
      start_(profile.start),
      stop_(profile.stop),
      port_(path, line),
      poller_(line.poll, profile.rate_hz) {
  restart();
}

SerialTransport::~SerialTransport() {
  for (const decode::Message& message : stop_) port_.write(message.bytes);
}

void SerialTransport::restart() noexcept {
  for (const decode::Message& message : start_) port_.write(message.bytes);
}

decode::ReceiveResult SerialTransport::deliver(decode::ReceivedBytes& out) noexcept {
  out = {std::span(held_).first(count_), last_ns_};
  count_ = 0;
  return decode::ReceiveResult::bytes;
}

decode::ReceiveResult SerialTransport::receive(decode::ReceivedBytes& out, std::int64_t give_up_ns) noexcept {
  for (;;) {
    const std::int64_t now_ns = monotonic_ns();
    if (poller_.expire(now_ns)) return decode::ReceiveResult::transfer_error;
    if (const auto* request = poller_.due(now_ns)) {
      port_.write(request->bytes);
      poller_.sent(now_ns);
    }
    const std::int64_t silent_ns = count_ > 0 ? last_ns_ + line_.silence_ns : kNever;
    const std::int64_t until_ns = std::min({give_up_ns, poller_.look_again_ns(), silent_ns});
    const std::ptrdiff_t got = port_.read(std::span(held_).subspan(count_), until_ns);
    if (got < 0) return decode::ReceiveResult::disconnected;
    if (got > 0) {
      count_ += static_cast<std::size_t>(got);
      received_ += static_cast<std::uint64_t>(got);
      last_ns_ = monotonic_ns();
      if (line_.silence_ns == 0 || count_ == held_.size()) return deliver(out);
    } else if (until_ns == silent_ns) {
      return deliver(out);
    } else if (until_ns == give_up_ns) {
      return decode::ReceiveResult::timeout;
    }
  }
}

std::string SerialTransport::why_no_frames(std::uint64_t garbage) const {
  const std::string at = std::to_string(line_.baud) + " baud";
  const LineErrors errors = port_.errors();
  if (errors.framing + errors.parity > 0)
    return std::to_string(errors.framing + errors.parity) + " bytes arrived damaged at " + at +
           ": the device has another baud rate or parity; give its own as device.baud, or in the profile";
  if (garbage > 0)
    return std::to_string(garbage) + " bytes arrived at " + at +
           " and made no packet of the profile: the device has another baud rate (device.baud), or is "
           "another "
           "device";
  if (received_ == 0 && !line_.poll.empty()) return "the device answers no request at " + at;
  return {};
}

}  // namespace slipd::serial
