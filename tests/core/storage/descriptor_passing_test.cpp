// Descriptors beside bytes on a Unix socket: each arrives once, and none is left open.
#include "core/storage/descriptor_passing.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <filesystem>
#include <string>

namespace slipd {
namespace {

std::ptrdiff_t open_files() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
}

bool same_file(int one, int other) {
  struct stat a {
  }, b{};
  return fstat(one, &a) == 0 && fstat(other, &b) == 0 && a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

class DescriptorPassing : public ::testing::Test {
 protected:
  void SetUp() override {
    std::array<int, 2> ends{};
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
    near_ = UniqueFd(ends[0]);
    far_ = UniqueFd(ends[1]);
    file_ = UniqueFd(memfd_create("passed", MFD_CLOEXEC));
  }
  std::string received() {
    std::array<char, 64> bytes{};
    const ssize_t got = receive_passed(far_.get(), bytes, passed_, 0);
    return got < 0 ? "error" : std::string(bytes.data(), static_cast<std::size_t>(got));
  }

  UniqueFd near_, far_, file_;
  PassedDescriptors passed_;
};

TEST_F(DescriptorPassing, ACopyOfTheDescriptorComesWithTheBytes) {
  ASSERT_EQ(send_passing(near_.get(), "with", file_.get(), 0), 4);
  EXPECT_EQ(received(), "with");
  ASSERT_EQ(passed_.count, 1U);
  EXPECT_NE(passed_.files[0].get(), file_.get());
  EXPECT_TRUE(same_file(passed_.files[0].get(), file_.get()));
  EXPECT_NE(fcntl(passed_.files[0].get(), F_GETFD) & FD_CLOEXEC, 0);
}

TEST_F(DescriptorPassing, BytesWithoutADescriptorBringNone) {
  ASSERT_EQ(send_passing(near_.get(), "with", file_.get(), 0), 4);
  EXPECT_EQ(received(), "with");
  ASSERT_EQ(send_passing(near_.get(), "out", -1, 0), 3);
  const std::ptrdiff_t before = open_files();
  EXPECT_EQ(received(), "out");
  EXPECT_EQ(passed_.count, 0U);
  EXPECT_EQ(open_files(), before - 1) << "that of the message before is closed";
}

TEST_F(DescriptorPassing, WhatIsNotSentPassesNothing) {
  far_ = {};
  const std::ptrdiff_t before = open_files();
  EXPECT_EQ(send_passing(near_.get(), "to nobody", file_.get(), MSG_NOSIGNAL), -1);
  EXPECT_EQ(errno, EPIPE);
  EXPECT_EQ(open_files(), before);
}

// A client may pass more than anyone takes, to leave them open in the receiver.
TEST_F(DescriptorPassing, OfTooManyTheFirstAreTakenAndNoneIsLeftOpen) {
  constexpr std::size_t kSent = 3 * kMostPassed;
  std::array<int, kSent> numbers{};
  numbers.fill(file_.get());
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof numbers)> control{};
  char byte = 'x';
  iovec piece{&byte, 1};
  msghdr message{};
  message.msg_iov = &piece;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr* const item = CMSG_FIRSTHDR(&message);
  item->cmsg_level = SOL_SOCKET;
  item->cmsg_type = SCM_RIGHTS;
  item->cmsg_len = CMSG_LEN(sizeof numbers);
  std::memcpy(CMSG_DATA(item), numbers.data(), sizeof numbers);
  const std::ptrdiff_t before = open_files();
  ASSERT_EQ(sendmsg(near_.get(), &message, 0), 1);
  EXPECT_EQ(received(), "x");
  EXPECT_EQ(passed_.count, kMostPassed);
  EXPECT_EQ(open_files(), before + static_cast<std::ptrdiff_t>(kMostPassed));
  passed_ = {};
  EXPECT_EQ(open_files(), before);
}

}  // namespace
}  // namespace slipd
