// The transport on libusb-1.0. It keeps as many transfers in flight as the device can fill while the acquire
// thread is preempted. receive() returns them in the order of completion, submits each again after use, and
// handles all events, so that no thread runs except libusb's own for hotplug events.
//
// libusb allocates a request on each submission and takes its own locks; slipd's code here does neither. A
// transfer of a stream has the size of one packet on the bus: a longer transfer would wait for bytes of the
// next frame whenever a frame ends at a packet's end.
#include <libusb-1.0/libusb.h>

#include <algorithm>
#include <array>
#include <utility>

#include "drivers/pacing.hpp"
#include "drivers/usb/find.hpp"

namespace slipd::usb {
namespace {

constexpr std::size_t kInFlightBytes = 16384, kMostTransfers = 32, kFewestTransfers = 8;
constexpr unsigned kMessageTimeoutMs = 1000;
constexpr int kMostErrors = 16;  // consecutive errors, after which the device counts as disconnected
constexpr std::int64_t kCloseNs = 2'000'000'000;
constexpr std::uint8_t kClassRequest = 0x21, kSetLineCoding = 0x20, kSetLineState = 0x22;
constexpr std::uint16_t kReady = 3;  // data terminal ready, request to send

struct FreesTransfer {
  void operator()(libusb_transfer* transfer) const noexcept { libusb_free_transfer(transfer); }
};
using Transfer = std::unique_ptr<libusb_transfer, FreesTransfer>;

class LibusbTransport final : public Transport {
 public:
  LibusbTransport(FoundDevice found, const decode::Profile& profile)
      : found_(std::move(found)), profile_(profile), usb_(*profile.usb) {
    claim();
    try {
      set_line();
      make_transfers();
      for (Slot& slot : slots_) submit(slot);
      for (const decode::Message& message : profile_.start) tell(message);
    } catch (...) {
      close();
      throw;
    }
  }
  LibusbTransport(const LibusbTransport&) = delete;
  LibusbTransport& operator=(const LibusbTransport&) = delete;
  ~LibusbTransport() override { close(); }

  ReceiveResult receive(ReceivedBytes& out, std::int64_t give_up_ns) noexcept override {
    if (handed_ != nullptr) submit(*std::exchange(handed_, nullptr));
    for (;;) {
      while (done_count_ > 0) {
        const ReceiveResult got = take(*pop(), out);
        if (got != ReceiveResult::timeout) return got;
      }
      if (gone_) return ReceiveResult::disconnected;
      if (halted_ && under_way_ == 0) recover();
      const std::int64_t left_ns = give_up_ns - monotonic_ns();
      handle_events(std::max<std::int64_t>(0, left_ns));
      if (left_ns <= 0 && done_count_ == 0 && !gone_) return ReceiveResult::timeout;
    }
  }

  void restart() noexcept override {
    for (Slot& slot : starts_) {
      if (!slot.under_way) submit(slot);
    }
  }

 private:
  // A transfer: of data in slots_, of a start message in starts_.
  struct Slot {
    Transfer transfer;
    std::vector<std::uint8_t> buffer;
    LibusbTransport* owner = nullptr;
    std::int64_t time_ns = 0;
    bool under_way = false, brings = false;
  };

  [[noreturn]] void refuse(const std::string& what, int code) const {
    throw DriverError(found_.name() + ": " + what + ": " + libusb_strerror(code));
  }

  // libusb gives an interface back to the kernel's driver when it is released; a serial port's two go
  // together.
  void claim() {
    libusb_set_auto_detach_kernel_driver(found_.handle.get(), 1);
    if (usb_.cdc_interface && *usb_.cdc_interface != usb_.interface) claim(*usb_.cdc_interface);
    claim(usb_.interface);
  }

  void claim(int interface) {
    const int code = libusb_claim_interface(found_.handle.get(), interface);
    if (code == 0) {
      claimed_.push_back(interface);
      return;
    }
    release();
    refuse("interface " + std::to_string(interface) +
               (code == LIBUSB_ERROR_BUSY ? " is another program's; end that one" : " is not to be had"),
           code);
  }

  void release() noexcept {
    for (; !claimed_.empty(); claimed_.pop_back())
      libusb_release_interface(found_.handle.get(), claimed_.back());
  }

  // As a terminal program does. Some devices refuse the requests and send data nevertheless.
  void set_line() {
    if (!usb_.cdc_interface) return;
    const auto interface = static_cast<std::uint16_t>(*usb_.cdc_interface);
    std::array<std::uint8_t, 7> coding{0, 0, 0, 0, 0, 0, 8};  // rate, one stop bit, no parity, eight bits
    for (std::size_t i = 0; i < 4; ++i) coding[i] = static_cast<std::uint8_t>(usb_.baud >> (8 * i));
    libusb_control_transfer(found_.handle.get(), kClassRequest, kSetLineCoding, 0, interface, coding.data(),
                            coding.size(), kMessageTimeoutMs);
    libusb_control_transfer(found_.handle.get(), kClassRequest, kSetLineState, kReady, interface, nullptr, 0,
                            kMessageTimeoutMs);
  }

  void make_transfers() {
    const int packet = libusb_get_max_packet_size(libusb_get_device(found_.handle.get()), usb_.in);
    if (packet <= 0) {
      throw DriverError(found_.name() + ": has no endpoint " + std::to_string(usb_.in) +
                        "; is the profile's usb.in right?");
    }
    auto size = static_cast<std::size_t>(packet);
    if (!profile_.stream) {
      const auto longest = std::ranges::max_element(profile_.scan, {}, &decode::PacketRule::length)->length;
      size = (longest + size - 1) / size * size;
    }
    slots_.resize(std::clamp(kInFlightBytes / size, kFewestTransfers, kMostTransfers));
    done_.resize(slots_.size());
    for (Slot& slot : slots_) {
      slot.buffer.resize(size);
      slot.brings = true;
      make(slot);
      libusb_fill_bulk_transfer(slot.transfer.get(), found_.handle.get(), usb_.in, slot.buffer.data(),
                                static_cast<int>(size), on_complete, &slot, 0);
    }
    starts_.resize(profile_.start.size());
    for (std::size_t i = 0; i < starts_.size(); ++i) make_start(starts_[i], profile_.start[i]);
  }

  void make(Slot& slot) {
    slot.owner = this;
    slot.transfer.reset(libusb_alloc_transfer(0));
    if (!slot.transfer) throw DriverError(found_.name() + ": no memory for transfers");
  }

  void make_start(Slot& slot, const decode::Message& message) {
    make(slot);
    if (!message.control) {
      slot.buffer = message.bytes;
      libusb_fill_bulk_transfer(slot.transfer.get(), found_.handle.get(), usb_.out, slot.buffer.data(),
                                static_cast<int>(slot.buffer.size()), on_complete, &slot, kMessageTimeoutMs);
      return;
    }
    const decode::UsbControl& control = *message.control;
    slot.buffer.resize(LIBUSB_CONTROL_SETUP_SIZE + answer_size(message));
    libusb_fill_control_setup(slot.buffer.data(), control.type, control.request, control.value, control.index,
                              static_cast<std::uint16_t>(answer_size(message)));
    std::ranges::copy(message.bytes, slot.buffer.begin() + LIBUSB_CONTROL_SETUP_SIZE);
    libusb_fill_control_transfer(slot.transfer.get(), found_.handle.get(), slot.buffer.data(), on_complete,
                                 &slot, kMessageTimeoutMs);
  }

  static std::size_t answer_size(const decode::Message& message) noexcept {
    return std::max<std::size_t>(message.control->length, message.bytes.size());
  }

  // Set-up thread: waits until the device has accepted the message.
  void tell(const decode::Message& message) {
    std::vector<std::uint8_t> bytes = message.bytes;
    int code = 0;
    if (message.control) {
      const decode::UsbControl& control = *message.control;
      bytes.resize(answer_size(message));
      code = libusb_control_transfer(found_.handle.get(), control.type, control.request, control.value,
                                     control.index, bytes.data(), static_cast<std::uint16_t>(bytes.size()),
                                     kMessageTimeoutMs);
    } else {
      int sent = 0;
      code = libusb_bulk_transfer(found_.handle.get(), usb_.out, bytes.data(), static_cast<int>(bytes.size()),
                                  &sent, kMessageTimeoutMs);
    }
    if (code < 0) refuse("does not take its start message", code);
  }

  void submit(Slot& slot) noexcept {
    if (gone_ || (halted_ && slot.brings)) return;
    const int code = libusb_submit_transfer(slot.transfer.get());
    slot.under_way = code == 0;
    under_way_ += slot.under_way ? 1 : 0;
    gone_ = gone_ || code == LIBUSB_ERROR_NO_DEVICE;
  }

  // Called in handle_events(), by its thread. libusb calls it from C: it must not throw.
  static void LIBUSB_CALL on_complete(libusb_transfer* transfer) {
    Slot& slot = *static_cast<Slot*>(transfer->user_data);
    LibusbTransport& self = *slot.owner;
    slot.time_ns = monotonic_ns();
    slot.under_way = false;
    --self.under_way_;
    if (slot.brings) self.done_[(self.done_first_ + self.done_count_++) % self.done_.size()] = &slot;
  }

  Slot* pop() noexcept {
    Slot* const slot = done_[done_first_];
    done_first_ = (done_first_ + 1) % done_.size();
    --done_count_;
    return slot;
  }

  ReceiveResult take(Slot& slot, ReceivedBytes& out) noexcept {
    const auto size = static_cast<std::size_t>(slot.transfer->actual_length);
    switch (slot.transfer->status) {
      case LIBUSB_TRANSFER_COMPLETED:
        errors_ = 0;
        if (size == 0) {
          submit(slot);
          return ReceiveResult::timeout;
        }
        out = {std::span(slot.buffer).first(size), slot.time_ns};
        handed_ = &slot;
        return ReceiveResult::bytes;
      case LIBUSB_TRANSFER_NO_DEVICE:
        gone_ = true;
        return ReceiveResult::disconnected;
      case LIBUSB_TRANSFER_CANCELLED:
        return ReceiveResult::timeout;  // cancelled until the halt is cleared
      case LIBUSB_TRANSFER_STALL:
        halted_ = true;
        for (Slot& other : slots_) {
          if (other.under_way) libusb_cancel_transfer(other.transfer.get());
        }
        break;
      default:
        submit(slot);
    }
    gone_ = gone_ || ++errors_ >= kMostErrors;
    return gone_ ? ReceiveResult::disconnected : ReceiveResult::transfer_error;
  }

  // Clears a halt of the endpoint, once no transfer is in flight.
  void recover() noexcept {
    halted_ = false;
    gone_ = gone_ || libusb_clear_halt(found_.handle.get(), usb_.in) != 0;
    for (Slot& slot : slots_) submit(slot);
  }

  void handle_events(std::int64_t most_ns) noexcept {
    timeval most{static_cast<time_t>(most_ns / 1'000'000'000),
                 static_cast<suseconds_t>(most_ns % 1'000'000'000 / 1000)};
    libusb_handle_events_timeout_completed(found_.context.get(), &most, nullptr);
  }

  void close() noexcept {
    if (!gone_) {
      for (const decode::Message& message : profile_.stop) {
        try {
          tell(message);
        } catch (const DriverError&) {
          break;  // the device stays started
        }
      }
    }
    for (auto* list : {&slots_, &starts_}) {
      for (Slot& slot : *list) {
        if (slot.under_way) libusb_cancel_transfer(slot.transfer.get());
      }
    }
    const std::int64_t give_up_ns = monotonic_ns() + kCloseNs;
    while (under_way_ > 0 && monotonic_ns() < give_up_ns) handle_events(kCloseNs / 20);
    for (auto* list : {&slots_, &starts_}) {
      for (Slot& slot : *list) {
        // The kernel did not return the transfer and libusb still lists it: it must never be freed.
        if (slot.under_way) static_cast<void>(slot.transfer.release());
      }
    }
    release();
  }

  FoundDevice found_;
  decode::Profile profile_;
  decode::UsbMatch usb_;
  std::vector<int> claimed_;
  std::vector<Slot> slots_, starts_;
  std::vector<Slot*> done_;  // a ring, in the order in which they were filled
  std::size_t done_first_ = 0, done_count_ = 0;
  Slot* handed_ = nullptr;  // the caller of receive() reads its bytes
  int under_way_ = 0, errors_ = 0;
  bool halted_ = false, gone_ = false;
};

}  // namespace

OpenedDevice open_device(const decode::Profile& profile, const DeviceSelector& selector) {
  FoundDevice found = find_device(*profile.usb, selector);
  OpenedDevice out{nullptr, found.port, found.serial};
  out.transport = std::make_unique<LibusbTransport>(std::move(found), profile);
  return out;
}

}  // namespace slipd::usb
