// simulated-camera DEVICE --control SOCKET: a camera that looks at a gel with dots. Writes rendered pictures,
// JPEG, to the output side of a Video4Linux loopback (v4l2loopback), so that slipd-camera reads them from the
// kernel. Orders are datagrams on SOCKET:
//   press X Y    drags the middle of the gel by so many pixels from now on; press 0 0: rest
//   freeze, go   the last picture again and again, and no more
//   torn, whole  pictures end in the middle of their data, and no more
//   light F      pictures are F times as bright
//   flicker F    every second picture is
//   rate HZ      pictures a second
//   pause        no pictures until go
#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <sys/un.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "tests/camera/rendered_gel.hpp"

namespace {

using namespace slipd::testing;

int checked(int result, const std::string& what) {
  if (result < 0) throw std::system_error(errno, std::generic_category(), what);
  return result;
}

class SimulatedCamera {
 public:
  SimulatedCamera(const std::string& device, const std::string& control, double rate_hz)
      : device_(checked(open(device.c_str(), O_RDWR | O_CLOEXEC), device)),
        orders_(checked(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0), "control socket")),
        timer_(checked(timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC), "timer")) {
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    format.fmt.pix.width = static_cast<unsigned>(gel_.width);
    format.fmt.pix.height = static_cast<unsigned>(gel_.height);
    format.fmt.pix.pixelformat = V4L2_PIX_FMT_MJPEG;
    format.fmt.pix.sizeimage = static_cast<unsigned>(gel_.width * gel_.height);
    checked(ioctl(device_, VIDIOC_S_FMT, &format), device + " takes no pictures");
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    control.copy(address.sun_path, sizeof address.sun_path - 1);
    unlink(control.c_str());
    checked(bind(orders_, reinterpret_cast<const sockaddr*>(&address), sizeof address), control);
    set_rate(rate_hz);
  }

  // Until a signal ends the program.
  void run() {
    for (;;) {
      pollfd waits[] = {{orders_, POLLIN, 0}, {timer_, POLLIN, 0}};
      if (poll(waits, 2, -1) < 0) continue;
      if ((waits[0].revents & POLLIN) != 0) hear();
      std::uint64_t due = 0;
      if ((waits[1].revents & POLLIN) != 0 && read(timer_, &due, sizeof due) == sizeof due && !paused_)
        send();
    }
  }

 private:
  void set_rate(double rate_hz) const {
    const auto period_ns = static_cast<long>(1e9 / rate_hz);
    const timespec period{period_ns / 1'000'000'000, period_ns % 1'000'000'000};
    const itimerspec every{period, period};
    checked(timerfd_settime(timer_, 0, &every, nullptr), "timer");
  }

  void hear() {
    char bytes[256];
    const ssize_t length = recv(orders_, bytes, sizeof bytes, 0);
    if (length <= 0) return;
    std::istringstream text(std::string(bytes, static_cast<std::size_t>(length)));
    std::string order;
    text >> order;
    double number = 1;
    if (order == "press") {
      text >> x_ >> y_;
    } else if (order == "freeze" || order == "go") {
      frozen_ = order == "freeze";
      paused_ = false;
    } else if (order == "torn" || order == "whole") {
      torn_ = order == "torn";
    } else if (order == "pause") {
      paused_ = true;
    } else if (text >> number; order == "light" || order == "flicker") {
      (order == "light" ? light_ : flicker_) = number;
    } else if (order == "rate" && number > 0) {
      set_rate(number);
    } else {
      std::cerr << "simulated-camera: unknown order " << order << '\n';
    }
  }

  void send() {
    if (!frozen_ || jpeg_.empty()) {
      ++pictures_;
      const double brightness = light_ * (pictures_ % 2 == 0 ? flicker_ : 1);
      cv::imencode(".jpg", brightness * rendered(gel_, press(gel_, x_, y_, 0), pictures_), jpeg_,
                   {cv::IMWRITE_JPEG_QUALITY, 95});
    }
    const std::size_t size = torn_ ? jpeg_.size() / 2 : jpeg_.size();
    if (write(device_, jpeg_.data(), size) < 0)
      throw std::system_error(errno, std::generic_category(), "the loopback takes no picture");
  }

  // Small: a guest's processor is emulated.
  const RenderedGel gel_{.width = 160, .height = 120, .spacing = 20, .radius = 4};
  const int device_, orders_, timer_;
  float x_ = 0, y_ = 0;
  double light_ = 1, flicker_ = 1;
  bool frozen_ = false, torn_ = false, paused_ = false;
  std::uint32_t pictures_ = 0;
  std::vector<unsigned char> jpeg_;
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Plays a camera that looks at a gel, on a Video4Linux loopback"};
  std::string device, control;
  double rate_hz = 10;
  app.add_option("device", device, "the loopback, /dev/videoN")->required();
  app.add_option("--control", control, "take orders as datagrams on this Unix socket")->required();
  app.add_option("--rate-hz", rate_hz, "pictures a second")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  try {
    SimulatedCamera(device, control, rate_hz).run();
  } catch (const std::exception& error) {
    std::cerr << "simulated-camera: " << error.what() << '\n';
  }
  return 1;
}
