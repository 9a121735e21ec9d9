// Writes a recording's bytes: to a file, or to a socket that another program reads from. No reader is waited
// for longer than allowed: each send has MSG_DONTWAIT, because O_NONBLOCK belongs to the open socket.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <span>
#include <system_error>

namespace slipd {

// How long the reader of a socket is waited for.
struct OutputPatience {
  // Longest time in which the reader takes nothing, ms. Shorter: a reader that pauses loses its recording.
  // Longer: it is noticed later that a reader has stopped.
  std::chrono::milliseconds stalled{1000};
  // CLOCK_MONOTONIC, ns, from which on nothing is waited for, however much the reader takes; null: never.
  const std::atomic<std::int64_t>* until_ns = nullptr;
};

// Writes all of `bytes` to a file; a disk that hangs is waited for. Returns the system's error; how much was
// written is then not known. Not thread-safe for one descriptor. Called from the thread of a recording.
std::error_code write_file(int fd, std::span<const std::uint8_t> bytes) noexcept;

// Sends all of `bytes` to a stream socket of AF_UNIX. Returns timed_out if `patience` is over, or the
// system's error. Otherwise as write_file.
std::error_code send_bounded(int socket, std::span<const std::uint8_t> bytes,
                             const OutputPatience& patience) noexcept;

// Waits until the reader has read all that was sent. Returns timed_out if `patience` is over,
// connection_reset if the reader has closed its end before.
std::error_code await_read(int socket, const OutputPatience& patience) noexcept;

// Waits so long, or until the reader has closed its end: then it returns connection_reset.
std::error_code await_hang_up(int socket, std::chrono::milliseconds time) noexcept;

// Bytes of memory of what was sent and is not read yet; 0: all was read, or the reader is gone.
std::size_t unread_bytes(int socket) noexcept;

}  // namespace slipd
