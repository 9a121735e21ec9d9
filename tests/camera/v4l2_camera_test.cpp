// What is left of a camera that does not start. A file is the device: this program's ioctl(2) answers for it
// as a driver does, and refuses the request that a test names.
#include "camera/picture/v4l2_camera.hpp"

#include <gmock/gmock.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdarg>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include "tests/support/temp_folder.hpp"

namespace {

constexpr unsigned kBufferBytes = 4096, kBuffers = 4;
unsigned long refused = 0;

int answer(unsigned long request, void* argument) {
  if (request == refused) {
    errno = ENOSPC;
    return -1;
  }
  switch (request) {
    case VIDIOC_QUERYCAP:
      static_cast<v4l2_capability*>(argument)->device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
      return 0;
    case VIDIOC_REQBUFS:
      static_cast<v4l2_requestbuffers*>(argument)->count = kBuffers;
      return 0;
    case VIDIOC_QUERYBUF: {
      auto& buffer = *static_cast<v4l2_buffer*>(argument);
      buffer.length = kBufferBytes;
      buffer.m.offset = buffer.index * kBufferBytes;
      return 0;
    }
    case VIDIOC_S_FMT:
    case VIDIOC_S_PARM:
    case VIDIOC_QBUF:
    case VIDIOC_STREAMON:
    case VIDIOC_STREAMOFF:
      return 0;
    default:
      errno = EINVAL;
      return -1;
  }
}

}  // namespace

extern "C" int ioctl(int fd, unsigned long request, ...) noexcept {
  va_list rest;
  va_start(rest, request);
  void* const argument = va_arg(rest, void*);
  va_end(rest);
  return _IOC_TYPE(request) == 'V' ? answer(request, argument)
                                   : static_cast<int>(syscall(SYS_ioctl, fd, request, argument));
}

namespace slipd::camera {
namespace {

using ::testing::HasSubstr;

class V4l2CameraTest : public ::testing::Test {
 protected:
  V4l2CameraTest() : device_(folder_.write("video", std::string(kBuffers * kBufferBytes, '\0')).string()) {}
  ~V4l2CameraTest() override { refused = 0; }

  V4l2Camera camera() const {
    PictureWish wish;
    wish.width = 320;
    wish.height = 240;
    wish.rate_hz = 30;
    return {device_, wish, {}};
  }
  std::string trouble() const {
    try {
      camera();
    } catch (const std::system_error& error) {
      return error.what();
    }
    return "";
  }
  // How often the device is mapped into memory.
  int mappings() const {
    std::ifstream maps("/proc/self/maps");
    int found = 0;
    for (std::string line; std::getline(maps, line);) found += line.ends_with(device_) ? 1 : 0;
    return found;
  }
  // How often it is open.
  int descriptors() const {
    int found = 0;
    for (const auto& each : std::filesystem::directory_iterator("/proc/self/fd")) {
      std::error_code ignored;  // of the iterator's own
      found += std::filesystem::read_symlink(each, ignored) == device_ ? 1 : 0;
    }
    return found;
  }

  testing::TempFolder folder_;
  std::string device_;
};

TEST_F(V4l2CameraTest, HasItsBuffersUntilItEnds) {
  {
    const V4l2Camera running = camera();
    EXPECT_GT(mappings(), 0);
    EXPECT_EQ(descriptors(), 1);
  }
  EXPECT_EQ(mappings(), 0);
  EXPECT_EQ(descriptors(), 0);
}

TEST_F(V4l2CameraTest, LeavesNothingBehindWhenItDoesNotStart) {
  for (const unsigned long request : {VIDIOC_STREAMON, VIDIOC_QBUF, VIDIOC_QUERYBUF, VIDIOC_REQBUFS}) {
    refused = request;
    EXPECT_THAT(trouble(), HasSubstr(device_ + ": "));
    EXPECT_EQ(mappings(), 0) << request;
    EXPECT_EQ(descriptors(), 0) << request;
  }
}

}  // namespace
}  // namespace slipd::camera
