#include "drivers/push/push_socket.hpp"

#include <grp.h>
#include <pwd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

#include "core/storage/descriptor_passing.hpp"
#include "driver_api/driver.hpp"

namespace slipd::push {
namespace {

namespace fs = std::filesystem;

constexpr int kWaiting = 8;  // connections that the kernel keeps until slipd looks

[[noreturn]] void fail(const std::string& what, int error, const std::string& remedy) {
  throw DriverError(what + ": " + std::generic_category().message(error) +
                    (remedy.empty() ? "" : "; " + remedy));
}

// Makes the folder, for all to enter; who may send is said by the socket's mode. Nobody else may be able to
// put another socket in its place.
void make_folder(const fs::path& folder) {
  if (folder.empty()) return;
  if (::mkdir(folder.c_str(), 0755) == 0) {
    if (::chmod(folder.c_str(), 0755) != 0) fail("cannot set the mode of " + folder.string(), errno, "");
  } else if (errno != EEXIST) {
    fail("cannot make the folder " + folder.string(), errno,
         "make it, or give options.path in a folder that slipd may write to");
  }
  struct stat there {};
  if (::stat(folder.c_str(), &there) != 0) fail(folder.string(), errno, "");
  const bool others = (there.st_mode & S_IWOTH) != 0 && (there.st_mode & S_ISVTX) == 0;
  if (others || (there.st_uid != 0 && there.st_uid != ::geteuid()))
    throw DriverError(folder.string() +
                      " belongs to another user, or everybody may write to it: use a folder of slipd's own");
}

sockaddr_un address_of(const fs::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.native().copy(address.sun_path, sizeof address.sun_path - 1);
  return address;
}

// Throws unless the socket at `address` is one that nobody listens on, as a crash leaves it.
void remove_dead_socket(const sockaddr_un& address) {
  const std::string path = address.sun_path;
  struct stat there {};
  if (::lstat(path.c_str(), &there) != 0) return;
  if (!S_ISSOCK(there.st_mode))
    throw DriverError(path + " exists and is no socket: remove it, or give another options.path");
  const UniqueFd probe(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!probe) fail("cannot make a socket", errno, "");
  if (::connect(probe.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 ||
      errno != ECONNREFUSED)
    throw DriverError(path + " is in use by another program: stop it, or give another options.path");
  ::unlink(path.c_str());
}

// -1, which changes nothing, for an empty name.
uid_t user_of(const std::string& name) {
  if (name.empty()) return static_cast<uid_t>(-1);
  passwd entry{};
  passwd* found = nullptr;
  std::array<char, 4096> texts{};
  const int error = ::getpwnam_r(name.c_str(), &entry, texts.data(), texts.size(), &found);
  if (found == nullptr)
    fail("options.owner \"" + name + "\"", error == 0 ? ENOENT : error, "there is no such user here");
  return entry.pw_uid;
}

gid_t group_of(const std::string& name) {
  if (name.empty()) return static_cast<gid_t>(-1);
  group entry{};
  group* found = nullptr;
  std::array<char, 16384> texts{};
  const int error = ::getgrnam_r(name.c_str(), &entry, texts.data(), texts.size(), &found);
  if (found == nullptr)
    fail("options.group \"" + name + "\"", error == 0 ? ENOENT : error, "there is no such group here");
  return entry.gr_gid;
}

}  // namespace

PushSocket::PushSocket(fs::path path, unsigned mode, const std::string& owner, const std::string& group)
    : path_(std::move(path)) {
  make_folder(path_.parent_path());
  listen_at(mode, owner, group);
}

PushSocket::~PushSocket() {
  struct stat there {};
  if (made_ && ::lstat(path_.c_str(), &there) == 0 && made_ == std::pair(there.st_dev, there.st_ino))
    ::unlink(path_.c_str());
}

void PushSocket::listen_at(unsigned mode, const std::string& owner, const std::string& group) {
  remove_dead_socket(address_of(path_));
  UniqueFd made(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!made) fail("cannot make a socket", errno, "");
  refuse_descriptors(made.get());
  // Under another name until it listens with its owner and mode: a writer that sees the file can connect.
  const std::string file = path_.string();
  const std::string unready = file + kUnready;
  ::unlink(unready.c_str());
  const sockaddr_un address = address_of(unready);
  if (::bind(made.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    fail("cannot bind " + file, errno, "may slipd write to its folder?");
  try {
    if ((!owner.empty() || !group.empty()) && ::chown(unready.c_str(), user_of(owner), group_of(group)) != 0)
      fail("cannot give " + file + " to options.owner and options.group", errno,
           "slipd has to be a member of the group (docs/push.md); an owner other than slipd requires root");
    if (::chmod(unready.c_str(), mode) != 0) fail("cannot set the mode of " + file, errno, "");
    if (::listen(made.get(), kWaiting) != 0) fail("cannot listen on " + file, errno, "");
    struct stat there {};
    if (::lstat(unready.c_str(), &there) == 0) made_.emplace(there.st_dev, there.st_ino);
    if (::rename(unready.c_str(), file.c_str()) != 0) fail("cannot make " + file, errno, "");
  } catch (...) {
    ::unlink(unready.c_str());
    throw;
  }
  listener_ = std::move(made);
}

}  // namespace slipd::push
