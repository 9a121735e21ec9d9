// Bytes on a Unix socket with file descriptors beside them (SCM_RIGHTS; unix(7)). Any one thread for each
// socket. Nothing allocates or throws.
#pragma once

#include <sys/socket.h>

#include <array>
#include <cstddef>
#include <cstring>
#include <span>
#include <string_view>

#include "core/storage/unique_fd.hpp"

namespace slipd {

// Most descriptors that are taken from one message. The kernel closes those beyond.
inline constexpr std::size_t kMostPassed = 4;

// Sends what the socket takes of `bytes`, as send(2) with `flags` does, and with their first byte a copy of
// `descriptor`; negative: none. Returns the number of bytes sent, -1 with errno if none was: then the
// descriptor was not sent either.
inline ssize_t send_passing(int socket, std::string_view bytes, int descriptor, int flags) noexcept {
  if (descriptor < 0) return send(socket, bytes.data(), bytes.size(), flags);
  iovec piece{const_cast<char*>(bytes.data()), bytes.size()};
  msghdr message{};
  message.msg_iov = &piece;
  message.msg_iovlen = 1;
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof descriptor)> control{};
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr* const item = CMSG_FIRSTHDR(&message);
  item->cmsg_level = SOL_SOCKET;
  item->cmsg_type = SCM_RIGHTS;
  item->cmsg_len = CMSG_LEN(sizeof descriptor);
  std::memcpy(CMSG_DATA(item), &descriptor, sizeof descriptor);
  return sendmsg(socket, &message, flags);
}

// What came beside received bytes: `count` descriptors, oldest first, which programs that are started later
// do not inherit.
struct PassedDescriptors {
  std::array<UniqueFd, kMostPassed> files;
  std::size_t count = 0;
};

// Receives into `bytes`, as recv(2) with `flags` does, and replaces `passed` by the descriptors that came.
// Returns the number of bytes; 0: the other end has closed; -1: errno says why.
inline ssize_t receive_passed(int socket, std::span<char> bytes, PassedDescriptors& passed,
                              int flags) noexcept {
  iovec piece{bytes.data(), bytes.size()};
  msghdr message{};
  message.msg_iov = &piece;
  message.msg_iovlen = 1;
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(kMostPassed * sizeof(int))> control{};
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  passed = {};
  const ssize_t got = recvmsg(socket, &message, flags | MSG_CMSG_CLOEXEC);
  if (got < 0) return got;
  for (cmsghdr* item = CMSG_FIRSTHDR(&message); item != nullptr; item = CMSG_NXTHDR(&message, item)) {
    if (item->cmsg_level != SOL_SOCKET || item->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t sent = (item->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < sent && passed.count < kMostPassed; ++i) {
      int descriptor = -1;
      std::memcpy(&descriptor, CMSG_DATA(item) + i * sizeof descriptor, sizeof descriptor);
      passed.files[passed.count++] = UniqueFd(descriptor);
    }
  }
  return got;
}

// SO_PASSRIGHTS, which headers before Linux 6.16 lack; -1: its number is not known for this processor.
#if defined(SO_PASSRIGHTS)
inline constexpr int kPassRights = SO_PASSRIGHTS;
#elif defined(__sparc__) || defined(__hppa__)
inline constexpr int kPassRights = -1;
#else
inline constexpr int kPassRights = 83;
#endif

// Lets the kernel refuse descriptors that are sent to this socket, or to a connection made to it from now on:
// the sender gets EPERM and nothing is sent. Before Linux 6.16 it does nothing.
inline void refuse_descriptors(int socket) noexcept {
  const int none = 0;
  setsockopt(socket, SOL_SOCKET, kPassRights, &none, sizeof none);
}

// Whether the kernel refuses them. Of a connection that was accepted and not changed since, true means that
// it never bore one: it has this from its listener since it was made.
inline bool refuses_descriptors(int socket) noexcept {
  int passes = 1;
  socklen_t length = sizeof passes;
  return getsockopt(socket, SOL_SOCKET, kPassRights, &passes, &length) == 0 && passes == 0;
}

// Lets receive_bare see every descriptor. Otherwise a byte that was sent out of band (MSG_OOB) is invisible
// to it, and is dropped by the next read, with its descriptor.
inline void prepare_for_bare(int socket) noexcept {
  const int in_line = 1;
  setsockopt(socket, SOL_SOCKET, SO_OOBINLINE, &in_line, sizeof in_line);
}

// Receives into `bytes`, as recv(2) with MSG_DONTWAIT does, unless a descriptor comes with them: then it sets
// `bears_descriptor`, and leaves all where it is. It neither takes a descriptor nor lets the kernel drop one:
// whoever is the last to close a file may wait for as long as its other end wants.
inline ssize_t receive_bare(int socket, std::span<char> bytes, bool& bears_descriptor) noexcept {
  iovec piece{bytes.data(), bytes.size()};
  msghdr message{};
  message.msg_iov = &piece;
  message.msg_iovlen = 1;
  // A look ends behind the first message with descriptors. They do not fit: there is no room for any.
  const ssize_t seen = recvmsg(socket, &message, MSG_PEEK | MSG_DONTWAIT);
  bears_descriptor = seen > 0 && (message.msg_flags & MSG_CTRUNC) != 0;
  if (seen <= 0 || bears_descriptor) return seen;
  return recv(socket, bytes.data(), static_cast<std::size_t>(seen), MSG_DONTWAIT);  // not what came since
}

}  // namespace slipd
