#include "core/model/whole_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <string>
#include <system_error>

namespace slipd {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& file, const std::string& what, int error) {
  // std::generic_category instead of strerror, whose buffer is shared by all threads.
  throw std::runtime_error(file.string() + what + std::generic_category().message(error));
}

void write_synced(const fs::path& file, std::span<const std::uint8_t> bytes, unsigned mode) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, mode);
  if (descriptor < 0) refuse(file, ": cannot be written: ", errno);
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
  // Two that write the same file at once write each into one of its own.
  const fs::path beside = file.string() + ".new-" + std::to_string(::getpid());
  try {
    write_synced(beside, bytes, mode);
    fs::rename(beside, file);
  } catch (...) {
    fs::remove(beside, error);
    throw;
  }
}

}  // namespace slipd
