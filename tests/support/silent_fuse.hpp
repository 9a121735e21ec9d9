// A file system in user space with one file, whose server never answers when the file is closed (FUSE_FLUSH,
// FUSE_RELEASE): who closes a descriptor of it waits until this object is destroyed. Needs the right to
// mount.
#pragma once

#include <fcntl.h>
#include <linux/fuse.h>
#include <poll.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <thread>

#include "core/storage/unique_fd.hpp"

namespace slipd::testing {

class SilentFuse {
 public:
  // Mounts it on `folder`, if that is permitted.
  explicit SilentFuse(const std::filesystem::path& folder)
      : folder_(folder), device_(::open("/dev/fuse", O_RDWR | O_CLOEXEC)) {
    const std::string options =
        "fd=" + std::to_string(device_.get()) + ",rootmode=40000,user_id=0,group_id=0,allow_other";
    mounted_ = device_ && mount("silent", folder.c_str(), "fuse", 0, options.c_str()) == 0;
    if (mounted_) server_ = std::jthread([this](const std::stop_token& stop) { serve(stop); });
  }
  ~SilentFuse() {
    if (!mounted_) return;
    umount2(folder_.c_str(), MNT_DETACH);
    server_ = {};
  }
  SilentFuse(const SilentFuse&) = delete;
  SilentFuse& operator=(const SilentFuse&) = delete;

  bool mounted() const { return mounted_; }
  // A new descriptor of its file.
  UniqueFd file() const { return UniqueFd(::open((folder_ / "file").c_str(), O_RDWR | O_CLOEXEC)); }

 private:
  static constexpr std::uint64_t kFile = 2;  // node; the folder is FUSE_ROOT_ID

  static fuse_attr attributes(std::uint64_t node) {
    fuse_attr attr{};
    attr.ino = node;
    attr.mode = node == kFile ? S_IFREG | 0666 : S_IFDIR | 0777;
    attr.nlink = 1;
    return attr;
  }

  template <typename Body>
  void answer(std::uint64_t unique, const Body& body) {
    fuse_out_header head{static_cast<std::uint32_t>(sizeof head + sizeof body), 0, unique};
    std::array<iovec, 2> parts{{{&head, sizeof head}, {const_cast<Body*>(&body), sizeof body}}};
    [[maybe_unused]] const auto sent = writev(device_.get(), parts.data(), parts.size());
  }

  void serve(const std::stop_token& stop) {
    std::array<char, 1 << 16> bytes{};
    while (!stop.stop_requested()) {
      pollfd ready{device_.get(), POLLIN, 0};
      poll(&ready, 1, 10);  // ms, then it looks whether it has to stop
      if ((ready.revents & POLLIN) == 0) continue;
      if (read(device_.get(), bytes.data(), bytes.size()) <= 0) continue;
      fuse_in_header in{};
      std::memcpy(&in, bytes.data(), sizeof in);
      take(in);
    }
    close(device_.release());  // whoever waits for an answer gets an error
  }

  void take(const fuse_in_header& in) {
    constexpr std::uint64_t kLongS = 3600;
    switch (in.opcode) {
      case FUSE_INIT: {
        fuse_init_out out{};
        out.major = FUSE_KERNEL_VERSION;
        out.minor = FUSE_KERNEL_MINOR_VERSION;
        out.max_write = 4096;
        return answer(in.unique, out);
      }
      case FUSE_LOOKUP: {
        fuse_entry_out out{};
        out.nodeid = kFile;
        out.entry_valid = out.attr_valid = kLongS;
        out.attr = attributes(kFile);
        return answer(in.unique, out);
      }
      case FUSE_GETATTR: {
        fuse_attr_out out{};
        out.attr_valid = kLongS;
        out.attr = attributes(in.nodeid);
        return answer(in.unique, out);
      }
      case FUSE_OPEN:
        return answer(in.unique, fuse_open_out{});
      case FUSE_FLUSH:
      case FUSE_RELEASE:
      case FUSE_FORGET:
      case FUSE_BATCH_FORGET:
      case FUSE_INTERRUPT:
        return;
      default: {
        const fuse_out_header out{sizeof out, -ENOSYS, in.unique};
        [[maybe_unused]] const auto sent = write(device_.get(), &out, sizeof out);
      }
    }
  }

  std::filesystem::path folder_;
  UniqueFd device_;
  bool mounted_ = false;
  std::jthread server_;
};

}  // namespace slipd::testing
