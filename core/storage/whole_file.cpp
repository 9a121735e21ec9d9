#include "core/storage/whole_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <string>
#include <system_error>

#include "core/storage/unique_fd.hpp"

namespace slipd {
namespace {

namespace fs = std::filesystem;
constexpr const char* kMark = ".new-";  // of a temporary file: FILE.new-PID

[[noreturn]] void refuse(const fs::path& file, const std::string& what, int error) {
  // Not strerror: its buffer is shared by all threads.
  throw std::runtime_error(file.string() + what + std::generic_category().message(error));
}

// Removes the temporary files of killed writers. A running writer holds a lock on its own.
void remove_abandoned(const fs::path& file) {
  const std::string begin = file.filename().string() + kMark;
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::error_code ignored;
  for (const auto& item : fs::directory_iterator(folder, ignored)) {
    if (!item.path().filename().string().starts_with(begin)) continue;
    const UniqueFd left(::open(item.path().c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
    if (left && ::flock(left.get(), LOCK_EX | LOCK_NB) == 0) fs::remove(item.path(), ignored);
  }
}

void write_synced(const fs::path& file, std::span<const std::uint8_t> bytes, unsigned mode) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, mode);
  if (descriptor < 0) refuse(file, ": cannot be written: ", errno);
  ::flock(descriptor, LOCK_EX | LOCK_NB);
  ::fchmod(descriptor, mode);
  std::size_t written = 0;
  bool good = true;
  while (good && written < bytes.size()) {
    const auto n = ::write(descriptor, bytes.data() + written, bytes.size() - written);
    if (n > 0)
      written += static_cast<std::size_t>(n);
    else
      good = n < 0 && errno == EINTR;
  }
  good = good && ::fsync(descriptor) == 0;
  const int error = errno;
  ::close(descriptor);
  if (!good) refuse(file, ": cannot be written: ", error);
}

}  // namespace

void write_whole_file(const fs::path& file, std::span<const std::uint8_t> bytes, unsigned mode) {
  std::error_code error;
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), error);
  if (error) refuse(file.parent_path(), ": cannot be made: ", error.value());
  // The process id: two processes that write the same file at once need two temporary files.
  const fs::path beside = file.string() + kMark + std::to_string(::getpid());
  remove_abandoned(file);
  fs::remove(beside, error);  // left by an earlier process of the same id
  try {
    write_synced(beside, bytes, mode);
    fs::rename(beside, file);
  } catch (...) {
    fs::remove(beside, error);
    throw;
  }
}

std::vector<std::uint8_t> read_own_file(const fs::path& file, std::size_t most) {
  // Non-blocking, so that opening a pipe without writer does not wait. It is refused below.
  const UniqueFd opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (!opened) {
    if (errno == ELOOP)
      throw std::runtime_error(file.string() + ": is a symbolic link, which is not followed; remove it");
    refuse(file, ": cannot be read: ", errno);
  }
  struct stat status {};
  if (::fstat(opened.get(), &status) != 0) refuse(file, ": cannot be read: ", errno);
  if (!S_ISREG(status.st_mode)) throw std::runtime_error(file.string() + ": is no regular file; remove it");
  if (status.st_uid != 0 && status.st_uid != ::geteuid()) {
    throw std::runtime_error(file.string() + ": belongs to user " + std::to_string(status.st_uid) +
                             ", not to root or slipd's own user; remove it");
  }
  if ((status.st_mode & S_IWOTH) != 0)
    throw std::runtime_error(file.string() + ": can be written by everybody; remove it");
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > most) throw std::runtime_error(file.string() + ": is larger than any of slipd's; remove it");
  std::vector<std::uint8_t> bytes(size);
  std::size_t got = 0;
  while (got < size) {
    const auto n = ::read(opened.get(), bytes.data() + got, size - got);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) refuse(file, ": cannot be read: ", errno);
    if (n == 0) break;
    got += static_cast<std::size_t>(n);
  }
  bytes.resize(got);
  return bytes;
}

}  // namespace slipd
