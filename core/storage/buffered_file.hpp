// A regular file read from its start through one block of memory: what the readers of recordings and of CSV
// stand on. Memory is taken while setting up; peek and consume neither allocate nor throw, so a driver may
// call them while reading. They do wait for the disk. (Not mapped: a file cut short under a mapping ends the
// process with SIGBUS.)
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace slipd {

class BufferedFile {
 public:
  // Throws std::system_error when the file cannot be opened or is no regular file.
  BufferedFile(const std::filesystem::path& path, std::size_t capacity);
  ~BufferedFile();
  BufferedFile(BufferedFile&& other) noexcept;
  BufferedFile& operator=(BufferedFile&&) = delete;

  // The bytes at hand: at least `wanted` of them unless the file ends before or cannot be read, which error()
  // tells. `wanted` is cut to the capacity. Valid until the next call.
  std::span<const std::uint8_t> peek(std::size_t wanted) noexcept;
  void consume(std::size_t bytes) noexcept;

  std::uint64_t offset() const noexcept { return offset_; }  // of the first byte not consumed
  int error() const noexcept { return error_; }              // errno of the read that failed, else 0
  std::size_t capacity() const noexcept { return memory_.size(); }
  void reserve(std::size_t capacity);  // while setting up; never shrinks; what peek gave is no longer valid
  void rewind() noexcept;

 private:
  std::vector<std::uint8_t> memory_;
  std::size_t begin_ = 0, end_ = 0;  // the bytes at hand
  std::uint64_t offset_ = 0;
  int fd_ = -1;
  int error_ = 0;
};

}  // namespace slipd
