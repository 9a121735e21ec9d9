#include "drivers/hid/hid_driver.hpp"

#include <fcntl.h>
#include <hidapi/hidapi.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/storage/unique_fd.hpp"
#include "drivers/hid/descriptor.hpp"
#include "drivers/pacing.hpp"

namespace slipd::hid {
namespace {

constexpr std::size_t kLongestReport = 256;

std::string narrow(const wchar_t* text) {
  std::string out;
  for (; text != nullptr && *text != L'\0'; ++text) out += *text < 128 ? static_cast<char>(*text) : '?';
  return out;
}

std::string id_text(const decode::HidMatch& match) {
  char text[16];
  std::snprintf(text, sizeof text, "%04x:%04x", match.vendor, match.product);
  return text;
}

std::string text_of(const decode::HidMatch& match) {
  std::array<char, 48> usage{};
  std::snprintf(usage.data(), usage.size(), "%sof usage 0x%08x", match.vendor != 0 ? " " : "", match.usage);
  return "HID device " + (match.vendor != 0 ? id_text(match) : "") + (match.usage != 0 ? usage.data() : "");
}

bool has_numbers(const decode::Profile& profile) {
  return std::ranges::any_of(profile.scan, [](const decode::PacketRule& rule) { return rule.id != 0; });
}

// A udev rule decides on the file's owner and mode (EACCES), the service's unit on kinds of devices (EPERM).
std::string why_not_opened(const std::string& path) {
  std::string why = path + " cannot be opened: ";
  const UniqueFd file(::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK));
  if (file) return why + narrow(hid_error(nullptr));
  const int error = errno;
  why += std::generic_category().message(error);
  if (error == EPERM) {
    return why +
           ": the service's unit does not permit it: install slipd-driver-hid; if it is installed, restart "
           "slipd, which started before the kernel had any HID device";
  }
  if (error == EACCES)
    return why + ": no udev rule gives it to slipd: add a line for it as in 60-slipd-hid.rules";
  return why;
}

struct Found {
  std::string path, serial;
};

std::vector<Found> devices_of(const decode::HidMatch& match) {
  const std::unique_ptr<hid_device_info, decltype(&hid_free_enumeration)> list(
      hid_enumerate(match.vendor, match.product), hid_free_enumeration);
  std::vector<Found> found;
  for (const hid_device_info* item = list.get(); item != nullptr; item = item->next) {
    const std::uint32_t usage = std::uint32_t{item->usage_page} << 16 | item->usage;
    if (match.usage == 0 || match.usage == usage) found.push_back({item->path, narrow(item->serial_number)});
  }
  return found;
}

}  // namespace

void HidDriver::Closes::operator()(hid_device_* device) const noexcept {
  hid_close(device);
}

HidDriver::HidDriver(const std::vector<SensorSetup>& sensors)
    : profile_(decode::profile_of(sensors, "hid")), setups_(sensors), sensors_(profile_, sensors) {
  const SensorSetup& first = sensors.front();
  try {
    serial_ = first.device.value("serial", "");
    path_ = first.device.value("path", "");
  } catch (const nlohmann::json::exception&) {
    throw DriverError("sensor \"" + first.name +
                      "\": device: expected {\"serial\": \"…\"} or {\"path\": \"/dev/hidraw0\"}, or nothing");
  }
  by_usage_ = std::ranges::any_of(profile_.scan, [](const decode::PacketRule& rule) {
    return std::ranges::any_of(rule.fields, [](const decode::Field& field) { return field.usage != 0; });
  });
  has_report_ids_ = has_numbers(profile_);
}

DeviceInfo HidDriver::open() {
  close();
  std::vector<Found> found = devices_of(*profile_.hid);
  const std::string id = text_of(*profile_.hid);
  std::string there;
  for (const Found& one : found)
    there += (there.empty() ? "" : ", ") + one.path + " (serial " + one.serial + ")";
  std::erase_if(found, [this](const Found& one) {
    return (!serial_.empty() && one.serial != serial_) || (!path_.empty() && one.path != path_);
  });
  if (found.empty()) {
    throw DriverError(id + (serial_.empty() ? "" : " of serial " + serial_) +
                      (path_.empty() ? "" : " at " + path_) + " is not there; there are: " +
                      (there.empty() ? "none" : there) + ". Plug it in, or correct the sensor's device");
  }
  if (found.size() > 1)
    throw DriverError(id + ": there are several: " + there + "; name one by device.serial or device.path");
  device_.reset(hid_open_path(found.front().path.c_str()));
  if (!device_) throw DriverError(id + ": " + why_not_opened(found.front().path));
  if (!send(profile_.start)) throw DriverError(id + ": does not take its start message");
  resolve_places(found.front().path);
  sensors_.reset();
  return {.description = profile_.description + " at " + found.front().path,
          .serial = found.front().serial,
          .simulated = false,
          .sensors = sensors_.info()};
}

// Reads places and scales from the device's descriptor, at each opening: another device can come back.
void HidDriver::resolve_places(const std::string& path) {
  if (!by_usage_) return;
  decode::Profile resolved = profile_;
  resolve_usages(resolved, descriptor_of(path));
  has_report_ids_ = has_numbers(resolved);
  sensors_ = decode::Sensors(resolved, setups_);
}

void HidDriver::close() noexcept {
  if (device_) send(profile_.stop);
  device_.reset();
}

// hidapi expects the report id in the first byte, 0 where the device has none.
bool HidDriver::send(const std::vector<decode::Message>& messages) noexcept {
  for (const decode::Message& message : messages) {
    std::array<std::uint8_t, kLongestReport> report{};
    const std::size_t size = std::min(message.bytes.size(), report.size() - 1);
    report[0] = static_cast<std::uint8_t>(message.id);
    std::copy_n(message.bytes.begin(), size, report.begin() + 1);
    const int sent = message.feature ? hid_send_feature_report(device_.get(), report.data(), size + 1)
                                     : hid_write(device_.get(), report.data(), size + 1);
    if (sent < 0) return false;
  }
  return true;
}

ReadResult HidDriver::take(std::span<const std::uint8_t> report, std::int64_t time_ns,
                           std::span<FrameSlot> slots) noexcept {
  std::uint32_t id = 0;
  if (has_report_ids_) {
    id = report.front();
    report = report.subspan(1);
  }
  return sensors_.take(id, report, time_ns, slots);
}

ReadResult HidDriver::read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept {
  if (const ReadResult waiting = sensors_.next_ready(); waiting.status == ReadStatus::frame) return waiting;
  const std::int64_t give_up_ns = monotonic_ns() + std::chrono::nanoseconds(timeout).count();
  std::array<std::uint8_t, kLongestReport> report;
  for (;;) {
    const std::int64_t left_ns = std::max<std::int64_t>(0, give_up_ns - monotonic_ns());
    const auto left_ms = static_cast<int>((left_ns + 999'999) / 1'000'000);
    const int size = hid_read_timeout(device_.get(), report.data(), report.size(), left_ms);
    if (size < 0) return {ReadStatus::disconnected, 0};
    if (size == 0) return {ReadStatus::timeout, 0};
    const ReadResult result =
        take(std::span(report).first(static_cast<std::size_t>(size)), monotonic_ns(), slots);
    if (result.status != ReadStatus::timeout) return result;
    if (left_ns == 0) return {ReadStatus::timeout, 0};
  }
}

}  // namespace slipd::hid
