#include "core/storage/regular_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

namespace slipd {
namespace {

const char* kind_of_file(mode_t mode) {
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

}  // namespace

UniqueFd open_regular_file(const std::filesystem::path& file) {
  // Non-blocking, so that opening a pipe without writer does not wait. No effect on a regular file.
  UniqueFd opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (!opened) throw std::system_error(errno, std::generic_category(), file.string());
  struct stat status {};
  if (::fstat(opened.get(), &status) != 0)
    throw std::system_error(errno, std::generic_category(), file.string());
  if (S_ISREG(status.st_mode)) return opened;
  throw std::system_error(
      std::make_error_code(S_ISDIR(status.st_mode) ? std::errc::is_a_directory : std::errc::not_supported),
      file.string() + ": is " + kind_of_file(status.st_mode) + ", not a regular file");
}

std::string read_regular_file(const std::filesystem::path& file, std::size_t most) {
  constexpr std::size_t kPiece = std::size_t{64} * 1024;
  const UniqueFd opened = open_regular_file(file);
  std::string text;
  for (;;) {
    const std::size_t had = text.size();
    text.resize(std::min(had + kPiece, most + 1));
    const ssize_t got = ::read(opened.get(), text.data() + had, text.size() - had);
    if (got < 0 && errno != EINTR) throw std::system_error(errno, std::generic_category(), file.string());
    text.resize(had + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    if (text.size() > most)
      throw std::system_error(std::make_error_code(std::errc::file_too_large), file.string());
    if (got == 0) return text;
  }
}

}  // namespace slipd
