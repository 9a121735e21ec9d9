#include "core/storage/buffered_file.hpp"

#include <sys/stat.h>
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

void BufferedFile::seek(std::uint64_t offset) noexcept {
  begin_ = end_ = 0;
  offset_ = offset;
  error_ = 0;
}

std::uint64_t BufferedFile::size() const noexcept {
  struct stat status {};
  return ::fstat(fd_.get(), &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
}

bool BufferedFile::read_at(std::uint64_t offset, std::span<std::uint8_t> out) const noexcept {
  std::size_t done = 0;
  while (done < out.size()) {
    const auto got =
        ::pread(fd_.get(), out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
    if (got == 0 || (got < 0 && errno != EINTR)) return false;
    if (got > 0) done += static_cast<std::size_t>(got);
  }
  return true;
}

}  // namespace slipd
