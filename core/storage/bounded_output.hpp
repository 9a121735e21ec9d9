// Writes to a descriptor that another program opened or reads from, without waiting for that program longer
// than allowed. O_NONBLOCK is no help: the flag belongs to the open file, and who shares the file can clear
// it at any time.
//
// What guarantees the limit:
//   regular file   its file system takes what it is given; nothing limits a disk that hangs
//   socket         each send has MSG_DONTWAIT
//   pipe, others   poll, then at most PIPE_BUF bytes, which a writable pipe takes at once. A second writer
//   that
//                  fills the pipe between the two calls makes the write wait; the caller must be prepared for
//                  that (Recorder leaves such a thread behind).
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <span>
#include <system_error>

namespace slipd {

// What a descriptor refers to.
enum class OutputKind : std::uint8_t { regular_file, pipe, socket, other };

// The kind of `fd`; `other` for devices, folders and descriptors that are not open.
OutputKind kind_of_output(int fd) noexcept;

// How long a write may wait.
struct OutputPatience {
  // Longest time in which the other end takes nothing, ms. Shorter: a reader that pauses loses its
  // recording. Longer: it is noticed later that a reader has stopped.
  std::chrono::milliseconds stalled{1000};
  // While it is true, `stalled` is 50 ms. Null: never. Written by another thread.
  const std::atomic<bool>* hurry = nullptr;
};

// Writes all of `bytes`. Returns timed_out if the other end took nothing for as long as `patience` allows, or
// the error of the system; how much was written is then not known. Not thread-safe for one descriptor.
// Called from the thread of a recording.
std::error_code write_bounded(int fd, OutputKind kind, std::span<const std::uint8_t> bytes,
                              const OutputPatience& patience) noexcept;

}  // namespace slipd
