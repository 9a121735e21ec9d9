// The socket in the file system: who may serve it, and a file that a crash left behind. A lock file beside it
// decides, so that two daemons that start at once cannot both win. io thread, at start and end.
#pragma once

#include <filesystem>
#include <string>

namespace slipd {

class SocketFile {
 public:
  // Takes the lock, removes a stale socket, binds and listens with the given mode. Throws std::runtime_error
  // that says who is in the way and what to do.
  SocketFile(std::filesystem::path path, unsigned mode);
  // Takes over a socket that somebody else made, listens on and will remove.
  explicit SocketFile(int listener);
  ~SocketFile();
  SocketFile(const SocketFile&) = delete;
  SocketFile& operator=(const SocketFile&) = delete;

  std::string name() const { return path_.string(); }
  int duplicate() const;  // of the listening descriptor, the caller's own. Throws std::system_error

 private:
  void lock();
  void bind_and_listen(unsigned mode);
  std::filesystem::path path_, lock_path_;
  int lock_fd_ = -1;  // none: the file is not ours
  int listener_ = -1;
};

}  // namespace slipd
