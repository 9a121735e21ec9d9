// The listening Unix socket and its file. A lock file beside it makes sure that one daemon at most serves it,
// and shows whether an existing socket was left by a crash.
#pragma once

#include <filesystem>
#include <string>

namespace slipd {

// Not thread-safe. Called from one thread: io.
class SocketFile {
 public:
  // Takes the lock, removes a stale socket, binds and listens with permissions `mode`. Throws
  // std::runtime_error that names who holds the lock or what else is wrong, and what to do.
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
  void lock();
  void bind_and_listen(unsigned mode);
  std::filesystem::path path_, lock_path_;
  int lock_fd_ = -1;  // -1: systemd made the socket
  int listener_ = -1;
};

}  // namespace slipd
