// slipd-driver-skeleton.so: a complete driver from which to start a new one. Its device is a Unix datagram
// socket. Each datagram is one frame: a u32 that counts the frames, then per taxel three floats (normal
// pressure, shear x, shear y; Pa), in the machine's byte order. Any program that sends these is a sensor.
//   { "name": "mine", "driver": "skeleton", "layout": { "grid": [4, 4], "pitch_mm": 4 },
//     "options": { "path": "/run/slipd/mine" } }
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <system_error>

#include "driver_api/driver.hpp"

namespace {

using namespace slipd;

// The keys under `options`. slipd checks them and fills in defaults before it creates the driver.
constexpr const char* kOptions = R"({
  "type": "object", "additionalProperties": false, "required": ["path"],
  "properties": {
    "path": { "type": "string", "minLength": 1, "maxLength": 100, "description": "Where the socket is made." }
  }
})";

std::int64_t now_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1000000000 + now.tv_nsec;
}

class SkeletonDriver final : public DeviceDriver {
 public:
  // One device has one sensor here. The constructor refuses what the schema cannot express, so that
  // `slipd --check-config` reports it.
  explicit SkeletonDriver(const std::vector<SensorSetup>& sensors)
      : setup_(sensors.front()), path_(setup_.options.at("path").get<std::string>()) {
    if (sensors.size() != 1)
      throw DriverError("sensor \"" + setup_.name +
                        "\": each socket is one sensor; give each its own device");
    datagram_.resize(sizeof(std::uint32_t) + 3 * sizeof(float) * setup_.layout.size());
  }
  ~SkeletonDriver() override { close(); }

  // Everything that takes time, allocates or can fail. Called again, with back-off, after read() has returned
  // `disconnected`. An error's text states what failed, why, and what to do.
  DeviceInfo open() override {
    close();
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.copy(address.sun_path, sizeof address.sun_path - 1);
    ::unlink(path_.c_str());
    socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (socket_ < 0 || ::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      const std::string why = std::generic_category().message(errno);
      close();
      throw DriverError("socket " + path_ + ": " + why + "; choose a folder that slipd may write to");
    }
    counted_ = false;
    return {.description = "datagrams at " + path_,
            .serial = "",
            .simulated = false,
            .sensors = {{SensorClass::array3, setup_.layout, setup_.rate_hz}}};
  }

  // From here on nothing allocates, locks, logs or throws, and nothing takes longer than `timeout`.
  ReadResult read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept override {
    const auto whole_ms = std::chrono::ceil<std::chrono::milliseconds>(timeout);
    pollfd wait{socket_, POLLIN, 0};
    if (::poll(&wait, 1, static_cast<int>(whole_ms.count())) <= 0) return {ReadStatus::timeout, 0};
    const ssize_t size = ::recv(socket_, datagram_.data(), datagram_.size(), MSG_TRUNC | MSG_DONTWAIT);
    const std::int64_t arrived_ns = now_ns();  // first of all: this is the frame's time
    if (size < 0) return {ReadStatus::disconnected, 0};
    if (size != static_cast<ssize_t>(datagram_.size())) return {ReadStatus::corrupt, 0};
    return take(slots[0], arrived_ns);
  }

  void close() noexcept override {
    if (socket_ < 0) return;
    ::close(socket_);
    ::unlink(path_.c_str());
    socket_ = -1;
  }

 private:
  ReadResult take(FrameSlot& slot, std::int64_t arrived_ns) noexcept {
    std::uint32_t count = 0;
    std::memcpy(&count, datagram_.data(), sizeof count);
    // The sequence rises with the device's count, so that lost frames are known; a frame that comes twice or
    // late is dropped.
    const std::uint32_t step = counted_ ? count - last_count_ : 1;
    if (step == 0 || step > UINT32_MAX / 2) return {ReadStatus::corrupt, 0};
    const char* at = datagram_.data() + sizeof count;
    for (std::size_t i = 0; i < slot.normal_pa.size(); ++i) {
      for (float* const value : {&slot.normal_pa[i], &slot.shear_x_pa[i], &slot.shear_y_pa[i]}) {
        std::memcpy(value, at, sizeof *value);
        at += sizeof *value;
        if (!std::isfinite(*value)) return {ReadStatus::corrupt, 0};  // the next frame overwrites the slot
      }
    }
    counted_ = true;
    last_count_ = count;
    slot.sequence = sequence_ += step;
    slot.time_ns = arrived_ns;
    slot.device_time_ns = -1;
    slot.truth = {};
    return {ReadStatus::frame, 0};
  }

  SensorSetup setup_;
  std::string path_;
  std::vector<char> datagram_;
  int socket_ = -1;
  bool counted_ = false;
  std::uint32_t last_count_ = 0;
  std::uint64_t sequence_ = 0;
};

std::unique_ptr<DeviceDriver> create(const std::vector<SensorSetup>& sensors) {
  return std::make_unique<SkeletonDriver>(sensors);
}

const DriverModule kModule{kDriverAbi, "skeleton",
                           "frames as datagrams on a Unix socket: a driver to start from", kOptions, create};

}  // namespace

SLIPD_DRIVER_MODULE(kModule)
