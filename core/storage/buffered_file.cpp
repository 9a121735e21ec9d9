#include "core/storage/buffered_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

namespace slipd {

BufferedFile::BufferedFile(const std::filesystem::path& path, std::size_t capacity) : memory_(capacity) {
  // Non-blocking, so that opening a pipe without writer does not wait. It is refused below.
  fd_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd_ < 0) throw std::system_error(errno, std::generic_category(), path.string());
  struct stat status {};
  if (::fstat(fd_, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(std::exchange(fd_, -1));
    throw std::system_error(
        std::make_error_code(S_ISDIR(status.st_mode) ? std::errc::is_a_directory : std::errc::not_supported),
        path.string() + ": not a regular file");
  }
}

BufferedFile::~BufferedFile() {
  if (fd_ >= 0) ::close(fd_);
}

BufferedFile::BufferedFile(BufferedFile&& other) noexcept
    : memory_(std::move(other.memory_)),
      begin_(other.begin_),
      end_(other.end_),
      offset_(other.offset_),
      fd_(std::exchange(other.fd_, -1)),
      error_(other.error_) {}

std::span<const std::uint8_t> BufferedFile::peek(std::size_t wanted) noexcept {
  wanted = std::min(wanted, memory_.size());
  if (end_ - begin_ < wanted && memory_.size() - begin_ < wanted) {
    std::memmove(memory_.data(), memory_.data() + begin_, end_ - begin_);
    end_ -= std::exchange(begin_, 0);
  }
  while (end_ - begin_ < wanted && error_ == 0) {
    const auto got = ::pread(fd_, memory_.data() + end_, memory_.size() - end_,
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
