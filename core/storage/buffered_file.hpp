// Reads a regular file from its start through one buffer. Used by the readers of recordings and of CSV. The
// buffer is allocated while setting up; peek and consume neither allocate nor throw, so that a driver's read
// may call them. They may wait for the disk. The file is not memory-mapped, because truncating a mapped file
// ends the process with SIGBUS.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/storage/unique_fd.hpp"

namespace slipd {

// Not thread-safe: one thread at a time.
class BufferedFile {
 public:
  // Opens `path` with a buffer of `capacity` bytes. Throws std::system_error if the file cannot be opened or
  // is not a regular file.
  BufferedFile(const std::filesystem::path& path, std::size_t capacity);

  // The buffered bytes from offset() on: at least `wanted` of them, fewer at the end of the file or after an
  // error. `wanted` is limited to the capacity. Valid until the next call.
  std::span<const std::uint8_t> peek(std::size_t wanted) noexcept;
  // Moves offset() forward by `bytes`, at most to the end of what peek returned.
  void consume(std::size_t bytes) noexcept;

  // Position in the file of the first byte that was not consumed.
  std::uint64_t offset() const noexcept { return offset_; }
  // errno of the read that failed; 0: none did.
  int error() const noexcept { return error_; }
  // Size of the buffer, bytes.
  std::size_t capacity() const noexcept { return memory_.size(); }
  // Enlarges the buffer; never shrinks it. Allocates, so only while setting up. Invalidates what peek
  // returned.
  void reserve(std::size_t capacity);
  // Continues at another position in the file and clears the error.
  void seek(std::uint64_t offset) noexcept;
  // Starts again at the beginning of the file and clears the error.
  void rewind() noexcept { seek(0); }

  // Size of the file now, bytes; 0 if it is unknown.
  std::uint64_t size() const noexcept;
  // Fills `out` from a position, beside the buffer. False: the file has not so many bytes there, or cannot be
  // read.
  bool read_at(std::uint64_t offset, std::span<std::uint8_t> out) const noexcept;

 private:
  std::vector<std::uint8_t> memory_;
  std::size_t begin_ = 0, end_ = 0;  // the buffered bytes
  std::uint64_t offset_ = 0;
  UniqueFd fd_;
  int error_ = 0;
};

}  // namespace slipd
