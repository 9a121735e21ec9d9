#include "camera/picture/v4l2_camera.hpp"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "bridges/support/clock.hpp"
#include "camera/picture/raw_picture.hpp"

namespace slipd::camera {
namespace {

constexpr unsigned kBuffers = 4;
constexpr int kPatienceMs = 2000;

std::uint32_t fourcc_of(PictureFormat format) {
  switch (format) {
    case PictureFormat::yuyv:
      return V4L2_PIX_FMT_YUYV;
    case PictureFormat::grey:
      return V4L2_PIX_FMT_GREY;
    case PictureFormat::mjpeg:
      break;
  }
  return V4L2_PIX_FMT_MJPEG;
}

std::string words_of(std::uint32_t fourcc) {
  constexpr unsigned kByte = 8;
  std::string out;
  for (unsigned i = 0; i < 4; ++i) out += static_cast<char>((fourcc >> (kByte * i)) & 0x7FU);
  return out;
}

int ioctl_again(int fd, unsigned long request, void* argument) {
  int result = 0;
  do {
    result = ioctl(fd, request, argument);
  } while (result < 0 && errno == EINTR);
  return result;
}

// As v4l2-ctl writes a control's name: "White Balance, Automatic" is white_balance_automatic.
std::string plain_name(const char* name) {
  std::string out;
  for (; *name != 0; ++name) {
    if (std::isalnum(static_cast<unsigned char>(*name)) != 0) {
      out += static_cast<char>(std::tolower(static_cast<unsigned char>(*name)));
    } else if (!out.empty() && out.back() != '_') {
      out += '_';
    }
  }
  while (out.ends_with('_')) out.pop_back();
  return out;
}

std::map<std::string, std::uint32_t> controls_of(int fd) {
  std::map<std::string, std::uint32_t> out;
  v4l2_query_ext_ctrl one{};
  one.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  while (ioctl_again(fd, VIDIOC_QUERY_EXT_CTRL, &one) == 0) {
    out[plain_name(one.name)] = one.id;
    one.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  return out;
}

bool is_automatic(const std::string& control) {
  return control.find("auto") != std::string::npos;
}

}  // namespace

V4l2Camera::Device::~Device() {
  if (fd >= 0) close(fd);
}

void V4l2Camera::Unmap::operator()(std::byte* at) const noexcept {
  munmap(at, size);
}

V4l2Camera::V4l2Camera(const std::string& device, const PictureWish& wish,
                       const std::map<std::string, int>& controls)
    : name_(device), wish_(wish), device_{open(device.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)} {
  if (device_.fd < 0) throw std::system_error(errno, std::generic_category(), name_);
  v4l2_capability able{};
  ask(VIDIOC_QUERYCAP, &able, "is no camera");
  if ((able.device_caps & V4L2_CAP_VIDEO_CAPTURE) == 0 || (able.device_caps & V4L2_CAP_STREAMING) == 0)
    throw std::runtime_error(name_ +
                             ": takes no pictures; a camera often has two devices, give the other one");
  set_format();
  set_rate();
  set_controls(controls);
  share_buffers();
}

V4l2Camera::~V4l2Camera() {
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  ioctl_again(device_.fd, VIDIOC_STREAMOFF, &type);
}

void V4l2Camera::ask(unsigned long request, void* argument, const char* what) const {
  if (ioctl_again(device_.fd, request, argument) < 0)
    throw std::system_error(errno, std::generic_category(), name_ + ": " + what);
}

void V4l2Camera::set_format() {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  auto& picture = format.fmt.pix;
  picture.width = static_cast<unsigned>(wish_.width);
  picture.height = static_cast<unsigned>(wish_.height);
  picture.pixelformat = fourcc_of(wish_.format);
  picture.field = V4L2_FIELD_NONE;
  const v4l2_pix_format asked = picture;
  ask(VIDIOC_S_FMT, &format, "takes no format");
  const auto text = [](const v4l2_pix_format& of) {
    return std::to_string(of.width) + " x " + std::to_string(of.height) + " " + words_of(of.pixelformat);
  };
  if (picture.width != asked.width || picture.height != asked.height ||
      picture.pixelformat != asked.pixelformat)
    throw std::runtime_error(name_ + ": has no pictures of " + text(asked) + ", it offers " + text(picture) +
                             " instead; change the profile's picture (v4l2-ctl --list-formats-ext)");
  stride_ = picture.bytesperline;
}

// A camera that cannot set its rate has its own.
void V4l2Camera::set_rate() {
  constexpr unsigned kUsPerSecond = 1'000'000;
  rate_hz_ = wish_.rate_hz;
  v4l2_streamparm stream{};
  stream.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  auto& period = stream.parm.capture.timeperframe;
  period = {static_cast<unsigned>(std::lround(kUsPerSecond / wish_.rate_hz)), kUsPerSecond};
  if (ioctl_again(device_.fd, VIDIOC_S_PARM, &stream) == 0 && period.numerator > 0 && period.denominator > 0)
    rate_hz_ = static_cast<double>(period.denominator) / period.numerator;
}

// Automatics first: while one is on, what it governs cannot be set.
void V4l2Camera::set_controls(const std::map<std::string, int>& controls) {
  const auto known = controls_of(device_.fd);
  for (const bool automatics : {true, false}) {
    for (const auto& [control, value] : controls) {
      if (is_automatic(control) != automatics) continue;
      const auto found = known.find(control);
      if (found == known.end())
        throw std::runtime_error(name_ + ": has no control \"" + control +
                                 "\"; see v4l2-ctl --list-ctrls, and the profile's controls");
      v4l2_control one{found->second, value};
      ask(VIDIOC_S_CTRL, &one, ("does not take control " + control + " = " + std::to_string(value)).c_str());
    }
  }
}

void V4l2Camera::share_buffers() {
  v4l2_requestbuffers wanted{};
  wanted.count = kBuffers;
  wanted.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  wanted.memory = V4L2_MEMORY_MMAP;
  ask(VIDIOC_REQBUFS, &wanted, "shares no buffers; another program may use it");
  for (unsigned i = 0; i < wanted.count; ++i) {
    v4l2_buffer one{};
    one.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    one.memory = V4L2_MEMORY_MMAP;
    one.index = i;
    ask(VIDIOC_QUERYBUF, &one, "shares no buffer");
    void* at = mmap(nullptr, one.length, PROT_READ | PROT_WRITE, MAP_SHARED, device_.fd, one.m.offset);
    if (at == MAP_FAILED) throw std::system_error(errno, std::generic_category(), name_ + ": mmap");
    Buffer buffer(static_cast<std::byte*>(at), Unmap{one.length});
    buffers_.push_back(std::move(buffer));
    ask(VIDIOC_QBUF, &one, "takes no buffer");
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  ask(VIDIOC_STREAMON, &type, "does not start; another camera may use all of the USB bus");
}

void V4l2Camera::wait() const {
  pollfd ready{device_.fd, POLLIN, 0};
  int got = 0;
  do {
    got = poll(&ready, 1, kPatienceMs);
  } while (got < 0 && errno == EINTR);
  if (got == 0) throw std::runtime_error(name_ + ": sends no pictures");
  if ((ready.revents & (POLLERR | POLLHUP)) != 0) throw std::runtime_error(name_ + ": is gone");
}

std::optional<Picture> V4l2Camera::next() {
  constexpr std::int64_t kNsPerSecond = 1'000'000'000, kNsPerUs = 1000;
  wait();
  v4l2_buffer newest{}, one{};
  bool have = false;
  for (;;) {
    one = {};
    one.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    one.memory = V4L2_MEMORY_MMAP;
    if (ioctl_again(device_.fd, VIDIOC_DQBUF, &one) < 0) {
      if (errno != EAGAIN) throw std::system_error(errno, std::generic_category(), name_ + ": is gone");
      if (have) break;
      wait();
      continue;
    }
    if (have) ask(VIDIOC_QBUF, &newest, "takes no buffer back");
    newest = one;
    have = true;
  }
  const Buffer& buffer = buffers_.at(newest.index);
  const std::span<const std::byte> bytes(buffer.get(),
                                         std::min<std::size_t>(newest.bytesused, buffer.get_deleter().size));
  Decoded decoded = decode(bytes, wish_, stride_);
  Picture picture;
  picture.brightness = std::move(decoded.brightness);
  picture.torn = decoded.torn || (newest.flags & V4L2_BUF_FLAG_ERROR) != 0;
  picture.sequence = std::uint64_t{newest.sequence} + 1;
  const bool monotonic = (newest.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  picture.time_ns = monotonic ? newest.timestamp.tv_sec * kNsPerSecond + newest.timestamp.tv_usec * kNsPerUs
                              : bridges::monotonic_ns();
  ask(VIDIOC_QBUF, &newest, "takes no buffer back");
  return picture;
}

}  // namespace slipd::camera
