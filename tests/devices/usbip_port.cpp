// A USB device served over USB/IP (the kernel's Documentation/usb/usbip_protocol.rst): `usbip attach` makes
// it a device of the machine. One device at bus id 1-1, one client. Messages are big-endian. A bulk IN
// request is kept until the device has data, like a pending transfer on the bus.
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <cerrno>
#include <deque>

#include "tests/devices/port.hpp"
#include "tests/devices/usb_requests.hpp"

namespace slipd::devices {
namespace {

constexpr std::uint16_t kVersion = 0x0111, kListRequest = 0x8005, kImportRequest = 0x8003;
constexpr std::uint32_t kSubmit = 1, kUnlink = 2, kSubmitted = 3, kUnlinked = 4;
constexpr std::size_t kOpHeader = 8, kBusId = 32, kUrbHeader = 48;
constexpr std::size_t kBacklog = 64;  // packets held for a host that does not read; the oldest are dropped

class UsbipPort final : public Port {
 public:
  UsbipPort(const DeviceModel& model, int port, std::string serial)
      : Port(model), port_(port), requests_(model, host_state_, std::move(serial)) {}

  void watch(std::vector<pollfd>& waits) const override {
    if (listener_) waits.push_back({listener_.get(), POLLIN, 0});
    if (client_) waits.push_back({client_.get(), POLLIN, 0});
  }

  void serve() override {
    pollfd wait{listener_.get(), POLLIN, 0};
    if (listener_ && ::poll(&wait, 1, 0) == 1) {
      hang_up();
      client_ = Fd(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
      const int yes = 1;
      ::setsockopt(client_.get(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    }
    if (!client_) return;
    std::uint8_t chunk[4096];
    const ssize_t got = ::recv(client_.get(), chunk, sizeof chunk, MSG_DONTWAIT);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (got <= 0) return hang_up();
    heard_.insert(heard_.end(), chunk, chunk + got);
    for (std::size_t used = 1; used > 0;) {
      used = imported_ ? take_urb() : take_operation();
      heard_.erase(heard_.begin(), heard_.begin() + static_cast<std::ptrdiff_t>(used));
    }
  }

  void send(std::span<const Packet> scan) override {
    for (const Packet& packet : scan) said_.push_back(packet.bytes);
    while (said_.size() > kBacklog) said_.pop_front();
    deliver();
  }

  void plug() override {
    if (plugged_) return;
    listener_ = listen_on_loopback(port_);
    start();
  }

  void unplug() override {
    listener_ = Fd();
    hang_up();
    plugged_ = false;
  }

  std::string place() const override { return std::to_string(port_); }

 private:
  struct Waiting {
    std::uint32_t sequence, length;
  };

  void hang_up() {
    client_ = Fd();
    imported_ = false;
    heard_.clear();
    said_.clear();
    waiting_.clear();
    if (plugged_) start();
  }

  template <std::integral T>
  T number(std::size_t at) const {
    T value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) value = static_cast<T>(value << 8 | heard_[at + i]);
    return value;
  }

  void reply(const Bytes& bytes) {
    if (::send(client_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL) < 0) client_ = Fd();
  }

  // Returns how many bytes were used: 0 while the message is incomplete.
  std::size_t take_operation() {
    if (heard_.size() < kOpHeader) return 0;
    const auto code = number<std::uint16_t>(2);
    const bool import = code == kImportRequest;
    if (import && heard_.size() < kOpHeader + kBusId) return 0;
    Bytes out;
    put_be(out, kVersion);
    put_be(out, static_cast<std::uint16_t>(code & 0x7FFF));
    put_be(out, std::uint32_t{0});
    if (code == kListRequest) put_be(out, std::uint32_t{1});
    append(out, requests_.usbip_record(code == kListRequest));
    reply(out);
    imported_ = import;
    return import ? kOpHeader + kBusId : kOpHeader;
  }

  std::size_t take_urb() {
    if (heard_.size() < kUrbHeader) return 0;
    const auto command = number<std::uint32_t>(0), sequence = number<std::uint32_t>(4);
    if (command == kUnlink) {
      const auto victim = number<std::uint32_t>(20);
      const bool found =
          std::erase_if(waiting_, [&](const Waiting& it) { return it.sequence == victim; }) > 0;
      answer(kUnlinked, sequence, found ? -ECONNRESET : 0, {}, 0);
      return kUrbHeader;
    }
    const bool in = number<std::uint32_t>(12) == 1;
    const auto endpoint = number<std::uint32_t>(16), length = number<std::uint32_t>(24);
    const std::size_t whole = kUrbHeader + (in ? 0 : length);
    if (command != kSubmit || heard_.size() < whole) return command == kSubmit ? 0 : heard_.size();

    const Bytes data(heard_.begin() + kUrbHeader, heard_.begin() + static_cast<std::ptrdiff_t>(whole));
    if (endpoint == 0) {
      const std::optional<Bytes> got = requests_.control(std::span(heard_).subspan(40, 8));
      const Bytes shown =
          got && in ? Bytes(got->begin(), got->begin() + std::min<std::ptrdiff_t>(length, std::ssize(*got)))
                    : Bytes{};
      answer(kSubmitted, sequence, got ? 0 : -EPIPE, shown, in ? shown.size() : length);
    } else if (!in) {
      if (model_.receive) model_.receive({endpoint, data}, host_state_);
      answer(kSubmitted, sequence, 0, {}, length);
    } else if ((endpoint | 0x80U) == model_.usb->in_endpoint) {
      waiting_.push_back({sequence, length});
      deliver();
    }  // an interrupt endpoint stays silent
    return whole;
  }

  void answer(std::uint32_t command, std::uint32_t sequence, int status, const Bytes& data,
              std::size_t length) {
    Bytes out;
    for (const std::uint32_t word : {command, sequence, 0U, 0U, 0U, static_cast<std::uint32_t>(status)})
      put_be(out, word);
    if (command == kSubmitted) put_be(out, static_cast<std::uint32_t>(length));
    out.resize(kUrbHeader, 0);
    append(out, data);
    reply(out);
  }

  // A transfer ends after one packet, or when its buffer is full.
  void deliver() {
    while (client_ && !waiting_.empty() && !said_.empty()) {
      Bytes& next = said_.front();
      const auto take = std::min<std::ptrdiff_t>(waiting_.front().length, std::ssize(next));
      answer(kSubmitted, waiting_.front().sequence, 0, Bytes(next.begin(), next.begin() + take),
             static_cast<std::size_t>(take));
      waiting_.pop_front();
      next.erase(next.begin(), next.begin() + take);
      if (next.empty()) said_.pop_front();
    }
  }

  int port_;
  UsbRequests requests_;
  Fd listener_, client_;
  bool imported_ = false;
  Bytes heard_;
  std::deque<Bytes> said_;
  std::deque<Waiting> waiting_;
};

}  // namespace

std::unique_ptr<Port> make_usbip_port(const DeviceModel& model, int tcp_port, const std::string& serial) {
  return std::make_unique<UsbipPort>(model, tcp_port, serial);
}

}  // namespace slipd::devices
