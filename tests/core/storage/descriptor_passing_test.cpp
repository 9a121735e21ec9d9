// Descriptors beside bytes on a Unix socket: each arrives once, and none is left open.
#include "core/storage/descriptor_passing.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <cerrno>
#include <filesystem>
#include <string>
#include <utility>

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

class BareReceiving : public DescriptorPassing {
 protected:
  void SetUp() override {
    DescriptorPassing::SetUp();
    prepare_for_bare(far_.get());
  }
  // What comes: bytes, "end", "nothing", or "descriptor".
  std::string bare() {
    std::array<char, 64> bytes{};
    bool bears = false;
    const ssize_t got = receive_bare(far_.get(), bytes, bears);
    if (bears) return "descriptor";
    if (got < 0) return errno == EAGAIN ? "nothing" : "error";
    return got == 0 ? "end" : std::string(bytes.data(), static_cast<std::size_t>(got));
  }
};

TEST_F(BareReceiving, BytesComeAsTheyWereSent) {
  EXPECT_EQ(bare(), "nothing");
  ASSERT_EQ(send_passing(near_.get(), "one ", -1, 0), 4);
  ASSERT_EQ(send_passing(near_.get(), "two", -1, 0), 3);
  EXPECT_EQ(bare(), "one two");
  near_ = {};
  EXPECT_EQ(bare(), "end");
}

TEST_F(BareReceiving, ADescriptorIsSeenAndNeitherTakenNorDropped) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe2(ends.data(), O_CLOEXEC), 0);
  const UniqueFd reading(ends[0]);
  UniqueFd writing(ends[1]);
  ASSERT_EQ(send_passing(near_.get(), "before", -1, 0), 6);
  ASSERT_EQ(send_passing(near_.get(), "with", writing.get(), 0), 4);
  writing = {};
  const std::ptrdiff_t before = open_files();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(bare(), "descriptor");
  EXPECT_EQ(open_files(), before);
  pollfd ended{reading.get(), 0, 0};
  EXPECT_EQ(poll(&ended, 1, 0), 0) << "the pipe's other end is still open";
}

// The kernel drops a byte out of band when the bytes behind it are read, unless it comes in line.
TEST_F(BareReceiving, ADescriptorBesideAByteOutOfBandIsSeenToo) {
  if (send_passing(near_.get(), "x", file_.get(), MSG_OOB) < 0) GTEST_SKIP() << "this kernel has none";
  ASSERT_EQ(send_passing(near_.get(), "after", -1, 0), 5);
  EXPECT_EQ(bare(), "descriptor");
}

class RefusedDescriptors : public DescriptorPassing {
 protected:
  void SetUp() override {
    DescriptorPassing::SetUp();
    refuse_descriptors(far_.get());
    if (!refuses_descriptors(far_.get())) GTEST_SKIP() << "this kernel cannot; Linux 6.16 and later can";
  }
};

TEST_F(RefusedDescriptors, AreNotSentNorAreTheirBytesAndTheConnectionGoesOn) {
  const std::ptrdiff_t before = open_files();
  for (const int flags : {0, int{MSG_OOB}, int{MSG_DONTWAIT}}) {
    EXPECT_EQ(send_passing(near_.get(), "with", file_.get(), flags), -1);
    EXPECT_EQ(errno, EPERM);
  }
  ASSERT_EQ(send_passing(near_.get(), "without", -1, 0), 7);
  EXPECT_EQ(received(), "without");
  EXPECT_EQ(passed_.count, 0U);
  EXPECT_EQ(open_files(), before);
}

TEST_F(RefusedDescriptors, TheOtherEndStillGetsThem) {
  ASSERT_EQ(send_passing(far_.get(), "with", file_.get(), 0), 4);
  std::swap(near_, far_);
  EXPECT_EQ(received(), "with");
  EXPECT_EQ(passed_.count, 1U);
}

// Of connections to a listener that began to refuse between them.
TEST_F(RefusedDescriptors, AConnectionIsLikeItsListenerWasWhenItWasMade) {
  const UniqueFd listener(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  socklen_t length = sizeof address;
  auto* const any = reinterpret_cast<sockaddr*>(&address);
  ASSERT_EQ(bind(listener.get(), any, sizeof address.sun_family), 0);  // the kernel chooses its name
  ASSERT_EQ(listen(listener.get(), 2), 0);
  ASSERT_EQ(getsockname(listener.get(), any, &length), 0);
  const auto connected = [&] {
    UniqueFd made(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    EXPECT_EQ(connect(made.get(), any, length), 0);
    return made;
  };
  const UniqueFd first = connected();
  refuse_descriptors(listener.get());
  const UniqueFd second = connected();
  EXPECT_EQ(send_passing(first.get(), "x", file_.get(), 0), 1);
  EXPECT_EQ(send_passing(second.get(), "x", file_.get(), 0), -1) << "before it is accepted";
  EXPECT_EQ(errno, EPERM);
  for (const bool refused : {false, true}) {
    const UniqueFd accepted(accept4(listener.get(), nullptr, nullptr, SOCK_CLOEXEC));
    EXPECT_EQ(refuses_descriptors(accepted.get()), refused);
  }
}

}  // namespace
}  // namespace slipd
