// Pictures of a camera by Video4Linux: the kernel fills buffers in shared memory, and each is decoded to
// brightness. Only the newest is: what has queued up meanwhile is given back, and shows as a jump of the
// sequence. One thread's own.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "camera/picture/picture_source.hpp"
#include "camera/profile/profile.hpp"

namespace slipd::camera {

class V4l2Camera final : public PictureSource {
 public:
  // Opens the device, sets format, rate and controls, and starts it. Throws std::runtime_error that says what
  // the device offers instead.
  V4l2Camera(const std::string& device, const PictureWish& wish, const std::map<std::string, int>& controls);
  ~V4l2Camera() override;
  V4l2Camera(const V4l2Camera&) = delete;
  V4l2Camera& operator=(const V4l2Camera&) = delete;

  // Throws std::runtime_error when the camera is gone or sends nothing for two seconds.
  std::optional<Picture> next() override;
  double rate_hz() const noexcept override { return rate_hz_; }

 private:
  struct Device {
    int fd = -1;
    ~Device();
  };
  // What the kernel fills, mapped into memory.
  struct Unmap {
    std::size_t size = 0;
    void operator()(std::byte* at) const noexcept;
  };
  using Buffer = std::unique_ptr<std::byte, Unmap>;
  void set_format();
  void set_rate();
  void set_controls(const std::map<std::string, int>& controls);
  void share_buffers();
  void wait() const;
  void ask(unsigned long request, void* argument, const char* what) const;

  std::string name_;
  PictureWish wish_;
  double rate_hz_ = 0;
  std::size_t stride_ = 0;
  Device device_;
  std::vector<Buffer> buffers_;
};

}  // namespace slipd::camera
