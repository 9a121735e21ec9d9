// The listening Unix socket and its file. A lock file beside it makes sure that one daemon at most serves it.
// The lock file may be deleted and the socket may be another program's; so a socket that is there already is
// replaced only if nobody listens on it, and what is removed at the end is the file that was made at the
// start, not whatever has its name then.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>

namespace slipd {

// Not thread-safe. Called from one thread: io.
class SocketFile {
 public:
  // Takes the lock, removes a socket that nobody listens on, binds and listens with permissions `mode`.
  // Throws std::runtime_error that names who holds the lock or the socket or what else is wrong, and what to
  // do.
  SocketFile(std::filesystem::path path, unsigned mode);
  // Uses a listening socket that systemd made. Its file is not removed.
  explicit SocketFile(int listener);
  ~SocketFile();
  SocketFile(const SocketFile&) = delete;
  SocketFile& operator=(const SocketFile&) = delete;

  // The path.
  std::string name() const { return path_.string(); }
  // A duplicate of the listening descriptor, owned by the caller. Throws std::system_error.
  int duplicate() const;

 private:
  // A file by its identity, which another file in its place does not have.
  struct Identity {
    dev_t device = 0;
    ino_t inode = 0;
    bool operator==(const Identity&) const = default;
  };
  static std::optional<Identity> identity_of(const std::filesystem::path& path);
  void remove_own_files() const;
  void lock();
  void bind_and_listen(unsigned mode);
  std::filesystem::path path_, lock_path_;
  int lock_fd_ = -1;  // -1: systemd made the socket
  int listener_ = -1;
  std::optional<Identity> made_;  // the socket's file, as it was made
};

}  // namespace slipd
