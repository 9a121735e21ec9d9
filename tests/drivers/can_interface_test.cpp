// Why a CAN interface cannot be used: the service that may not, the kernel that cannot, the interface that is
// none of CAN. Where the machine has CAN or not, a filter like the service manager's forbids it.
#include "drivers/can/can_interface.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <iterator>

#include "core/storage/unique_fd.hpp"

namespace slipd::can {
namespace {

using ::testing::HasSubstr;

// As RestrictAddressFamilies= without AF_CAN.
bool forbid_can() {
  sock_filter program[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_socket, 0, 3),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, PF_CAN, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EAFNOSUPPORT),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog filter{static_cast<unsigned short>(std::size(program)), program};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0;
}

TEST(CanInterface, AServiceThatMayNotUseCanIsToldThePackageAndNotThatTheKernelHasNone) {
  constexpr int kNoFilters = 77;
  const pid_t child = fork();
  if (child == 0) {
    if (!forbid_can()) _exit(kNoFilters);
    const int fd = socket(PF_CAN, SOCK_RAW, CAN_RAW);
    const bool told = fd < 0 && std::strstr(why_no_can(errno), "slipd-driver-can") != nullptr;
    _exit(told ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == kNoFilters) GTEST_SKIP() << "this kernel has no seccomp filters";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(CanInterface, AKernelWithoutCanIsToldWhereNothingForbidsIt) {
  EXPECT_THAT(why_no_can(EAFNOSUPPORT), HasSubstr("this kernel has no CAN"));
  EXPECT_THAT(why_no_can(EPROTONOSUPPORT), HasSubstr("can-raw"));
}

TEST(CanInterface, AnInterfaceOfAnotherKindIsCalledThat) {
  const UniqueFd any(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  ASSERT_TRUE(any);
  EXPECT_EQ(check_can_interface(any.get(), "lo"), not_can_error());
  EXPECT_EQ(check_can_interface(any.get(), "nosuch0"), ENODEV);
  EXPECT_THAT(why_no_can(not_can_error()), HasSubstr("no CAN interface"));
  EXPECT_THAT(why_no_can(ENODEV), HasSubstr("no such interface"));
}

TEST(CanInterface, OtherErrorsAreTheSystems) {
  EXPECT_STREQ(why_no_can(ENOMEM), "Cannot allocate memory");
  EXPECT_THAT(why_no_can(EMSGSIZE), HasSubstr("can.fd"));
  EXPECT_THAT(why_no_can(ENETDOWN), HasSubstr("down"));
}

}  // namespace
}  // namespace slipd::can
