#include "bridges/ros2/messages/sensor_messages.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace slipd::ros2 {
namespace {

constexpr std::int64_t kNsPerS = 1'000'000'000;

bool is_letter(char c) noexcept {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

bool is_digit(char c) noexcept {
  return c >= '0' && c <= '9';
}

constexpr std::array<const char*, 6> kPointFields{"x", "y", "z", "normal", "shear_x", "shear_y"};

}  // namespace

Time time_of(std::int64_t realtime_ns) noexcept {
  const std::int64_t seconds =
      realtime_ns >= 0 ? realtime_ns / kNsPerS : (realtime_ns - (kNsPerS - 1)) / kNsPerS;
  Time time;
  time.sec = static_cast<std::int32_t>(std::clamp<std::int64_t>(
      seconds, std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max()));
  time.nanosec = static_cast<std::uint32_t>(realtime_ns - seconds * kNsPerS);
  return time;
}

std::string topic_of(std::string_view prefix, std::string_view name, std::string_view leaf) {
  std::string token;
  if (!name.empty() && is_digit(name.front())) token += '_';
  for (const char c : name) token += is_letter(c) || is_digit(c) ? c : '_';
  return std::string(prefix) + "/" + token + "/" + std::string(leaf);
}

bool forces_hold(const SlipEstimate& estimate) noexcept {
  return estimate.state < SlipEstimate::kUnzeroed;
}

Float32 margin_of(const SlipEstimate& estimate) noexcept {
  Float32 margin;
  if (estimate.state == SlipEstimate::kOk) margin.data = static_cast<float>(estimate.margin);
  return margin;
}

Float32 margin_low_of(const SlipEstimate& estimate) noexcept {
  Float32 margin;
  if (forces_hold(estimate)) margin.data = static_cast<float>(estimate.margin_low);
  return margin;
}

WrenchStamped wrench_of(const SlipEstimate& estimate) {
  WrenchStamped message;
  message.header = estimate.header;
  if (!forces_hold(estimate)) return message;
  auto& [force, torque] = message.wrench;
  force = {estimate.shear_force_x, estimate.shear_force_y, -estimate.normal_force};
  // The forces act at the contact's centre, and with them the torque about the normal there.
  torque = {estimate.center_y * force.z, -estimate.center_x * force.z,
            estimate.torque + estimate.center_x * force.y - estimate.center_y * force.x};
  return message;
}

Wrench wrench_of(const Taxels& taxels, double area_m2, bool has_shear) noexcept {
  Wrench sum;
  Vector3& force = sum.force;
  Vector3& torque = sum.torque;
  force = torque = {0, 0, 0};
  for (std::size_t i = 0; i < taxels.normal_pa.size(); ++i) {
    const double x = area_m2 * static_cast<double>(taxels.shear_x_pa[i]);
    const double y = area_m2 * static_cast<double>(taxels.shear_y_pa[i]);
    const double z = -area_m2 * static_cast<double>(taxels.normal_pa[i]);
    force = {force.x + x, force.y + y, force.z + z};
    torque = {torque.x + taxels.y_m[i] * z, torque.y - taxels.x_m[i] * z,
              torque.z + taxels.x_m[i] * y - taxels.y_m[i] * x};
  }
  if (!has_shear) force.x = force.y = torque.z = kUnknown;
  // One taxel has no lever.
  if (taxels.normal_pa.size() == 1) torque = Vector3();
  return sum;
}

void fill_cloud(const Header& header, const Taxels& taxels, PointCloud2& cloud) {
  constexpr std::uint32_t kStep = sizeof(float) * kPointFields.size();
  cloud.header = header;
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(taxels.normal_pa.size());
  if (cloud.point_fields.empty()) {
    for (const char* name : kPointFields) {
      PointField& field = cloud.point_fields.emplace_back();
      field.name = name;
      field.offset = static_cast<std::uint32_t>(sizeof(float) * (cloud.point_fields.size() - 1));
    }
  }
  cloud.point_step = kStep;
  cloud.row_step = kStep * cloud.width;
  cloud.data.resize(cloud.row_step);
  for (std::size_t i = 0; i < cloud.width; ++i) {
    const std::array<float, kPointFields.size()> point{static_cast<float>(taxels.x_m[i]),
                                                       static_cast<float>(taxels.y_m[i]),
                                                       0.0F,
                                                       taxels.normal_pa[i],
                                                       taxels.shear_x_pa[i],
                                                       taxels.shear_y_pa[i]};
    std::memcpy(cloud.data.data() + i * kStep, point.data(), kStep);
  }
}

}  // namespace slipd::ros2
