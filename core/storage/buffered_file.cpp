#include "core/storage/buffered_file.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "core/storage/regular_file.hpp"

namespace slipd {

BufferedFile::BufferedFile(const std::filesystem::path& path, std::size_t capacity)
    : memory_(capacity), fd_(open_regular_file(path)) {}

std::span<const std::uint8_t> BufferedFile::peek(std::size_t wanted) noexcept {
  wanted = std::min(wanted, memory_.size());
  if (end_ - begin_ < wanted && memory_.size() - begin_ < wanted) {
    std::memmove(memory_.data(), memory_.data() + begin_, end_ - begin_);
    end_ -= std::exchange(begin_, 0);
  }
  while (end_ - begin_ < wanted && error_ == 0) {
    const auto got = ::pread(fd_.get(), memory_.data() + end_, memory_.size() - end_,
                             static_cast<off_t>(offset_ + (end_ - begin_)));
    if (got == 0) break;
    if (got > 0) {
      end_ += static_cast<std::size_t>(got);
    } else if (errno != EINTR) {
      error_ = errno;
    }
  }
  return {memory_.data() + begin_, end_ - begin_};
}

void BufferedFile::consume(std::size_t bytes) noexcept {
  bytes = std::min(bytes, end_ - begin_);
  begin_ += bytes;
  offset_ += bytes;
}

void BufferedFile::reserve(std::size_t capacity) {
  if (capacity > memory_.size()) memory_.resize(capacity);
}

void BufferedFile::rewind() noexcept {
  begin_ = end_ = 0;
  offset_ = 0;
  error_ = 0;
}

}  // namespace slipd
