#include "drivers/serial/serial_port.hpp"

// termios2, which has any baud rate; <termios.h> cannot be included beside it.
#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "driver_api/driver.hpp"
#include "drivers/pacing.hpp"

namespace slipd::serial {
namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& what) {
  throw DriverError(path + ": " + what);
}

std::string why_not_opened(int error) {
  switch (error) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
      return "there is no such serial line: plug the device in, or correct device.path (ls -l "
             "/dev/serial/by-id shows what is there)";
    case EACCES:
    case EPERM:
      return "slipd may not open it: add slipd's user to the group that owns it (ls -l), usually dialout";
    case EBUSY:
      return "another program has it open: end that one (fuser -v shows it)";
    default:
      return std::generic_category().message(error);
  }
}

tcflag_t flags_of(const decode::SerialLine& line) {
  tcflag_t flags = CS8 | CREAD | CLOCAL | BOTHER | (BOTHER << IBSHIFT);
  if (line.parity != 'N') flags |= PARENB;
  if (line.parity == 'O') flags |= PARODD;
  if (line.stop_bits == 2) flags |= CSTOPB;
  if (line.rts_cts) flags |= CRTSCTS;
  return flags;
}

void set_line(int fd, const std::string& path, const decode::SerialLine& line) {
  termios2 wanted{};
  wanted.c_cflag = flags_of(line);
  wanted.c_iflag = line.parity == 'N' ? IGNBRK : IGNBRK | INPCK;
  wanted.c_cc[VMIN] = 1;  // so that a read without bytes says EAGAIN, and one of a line that is gone 0
  wanted.c_ispeed = wanted.c_ospeed = line.baud;
  if (ioctl(fd, TCSETS2, &wanted) != 0)
    refuse(path, "is no serial line: " + std::generic_category().message(errno));
  termios2 got{};
  if (ioctl(fd, TCGETS2, &got) == 0 && got.c_ospeed != line.baud)
    refuse(path, "cannot send at " + std::to_string(line.baud) + " bit/s, the nearest it has is " +
                     std::to_string(got.c_ospeed) + ": correct the baud rate");
}

void set_rs485(int fd, const std::string& path) {
  serial_rs485 wanted{};
  wanted.flags = SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND;
  if (ioctl(fd, TIOCSRS485, &wanted) != 0)
    refuse(path,
           "its kernel driver cannot switch an RS-485 transceiver: remove \"rs485\" from the profile if "
           "the adapter does so itself");
}

// Adapters that collect bytes for up to 16 ms then pass them on at once. Those that know no such thing need
// none.
void ask_low_latency(int fd) {
  serial_struct line{};
  if (ioctl(fd, TIOCGSERIAL, &line) != 0) return;
  line.flags |= ASYNC_LOW_LATENCY;
  ioctl(fd, TIOCSSERIAL, &line);
}

}  // namespace

SerialPort::SerialPort(const std::string& path, const decode::SerialLine& line)
    : fd_(open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
  if (!fd_) refuse(path, why_not_opened(errno));
  if (ioctl(fd_.get(), TIOCEXCL) != 0)
    refuse(path, "is no serial line: " + std::generic_category().message(errno));
  if (flock(fd_.get(), LOCK_EX | LOCK_NB) != 0) refuse(path, why_not_opened(EBUSY));  // root passes the first
  set_line(fd_.get(), path, line);
  if (line.rs485) set_rs485(fd_.get(), path);
  ask_low_latency(fd_.get());
  ioctl(fd_.get(), TCFLSH, TCIOFLUSH);
  before_ = counted();
}

LineErrors SerialPort::counted() const noexcept {
  serial_icounter_struct counts{};
  if (ioctl(fd_.get(), TIOCGICOUNT, &counts) != 0) return {};
  return {static_cast<std::uint32_t>(counts.frame), static_cast<std::uint32_t>(counts.parity),
          static_cast<std::uint32_t>(counts.overrun) + static_cast<std::uint32_t>(counts.buf_overrun)};
}

LineErrors SerialPort::errors() const noexcept {
  const LineErrors now = counted();
  return {now.framing - before_.framing, now.parity - before_.parity, now.overrun - before_.overrun};
}

std::ptrdiff_t SerialPort::read(std::span<std::uint8_t> into, std::int64_t until_ns) noexcept {
  for (;;) {
    const ssize_t got = ::read(fd_.get(), into.data(), into.size());
    if (got > 0) return got;
    if (got == 0 || (errno != EAGAIN && errno != EINTR)) return -1;
    const std::int64_t left_ns = until_ns - monotonic_ns();
    if (left_ns <= 0) return 0;
    pollfd waiting{.fd = fd_.get(), .events = POLLIN, .revents = 0};
    const timespec patience{static_cast<time_t>(left_ns / 1000000000),
                            static_cast<long>(left_ns % 1000000000)};
    const int ready = ppoll(&waiting, 1, &patience, nullptr);
    if (ready == 0 || (ready < 0 && errno != EINTR)) return 0;
  }
}

bool SerialPort::write(std::span<const std::uint8_t> bytes) noexcept {
  return ::write(fd_.get(), bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
}

}  // namespace slipd::serial
