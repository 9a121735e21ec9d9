#include "drivers/modbus/modbus_driver.hpp"

#include <modbus/modbus.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <nlohmann/json.hpp>

#include "drivers/modbus/unreachable.hpp"
#include "drivers/pacing.hpp"

namespace slipd::modbus {
namespace {

constexpr auto kConnectPatience = std::chrono::seconds(1);
constexpr auto kAnswerPatience = std::chrono::milliseconds(50);
constexpr int kGoneAfter = 10;  // consecutive requests without an answer, after which slipd reconnects
constexpr std::int64_t kLongestLagNs = 100'000'000;

template <class Set>
void set_time(Set set, modbus_t* context, std::chrono::microseconds time) noexcept {
  const auto us = static_cast<std::uint32_t>(std::max<std::int64_t>(time.count(), 1));
  set(context, us / 1'000'000, us % 1'000'000);
}

[[noreturn]] void wrong_device(const SensorSetup& sensor) {
  throw DriverError("sensor \"" + sensor.name +
                    "\": device: expected {\"host\": \"192.168.1.1\", \"port\": 502} for Modbus TCP or "
                    "{\"serial_line\": \"/dev/ttyUSB0\"} for RTU; unit and baud may be given beside");
}

}  // namespace

void ModbusDriver::Closes::operator()(_modbus* context) const noexcept {
  modbus_close(context);
  modbus_free(context);
}

ModbusDriver::Endpoint ModbusDriver::endpoint_of(const SensorSetup& sensor, const decode::ModbusMap& map) {
  Endpoint endpoint;
  try {
    endpoint.host = sensor.device.value("host", "");
    endpoint.serial_line = sensor.device.value("serial_line", "");
    endpoint.port = sensor.device.value("port", map.tcp_port);
    endpoint.baud = sensor.device.value("baud", map.baud);
    endpoint.unit = sensor.device.value("unit", map.unit);
  } catch (const nlohmann::json::exception&) {
    wrong_device(sensor);
  }
  if (endpoint.host.empty() == endpoint.serial_line.empty() || endpoint.port < 1 || endpoint.port > 65535 ||
      endpoint.unit < 0 || endpoint.unit > 255 || endpoint.baud <= 0) {
    wrong_device(sensor);
  }
  endpoint.text =
      endpoint.host.empty() ? endpoint.serial_line : endpoint.host + ":" + std::to_string(endpoint.port);
  endpoint.text += ", unit " + std::to_string(endpoint.unit);
  return endpoint;
}

ModbusDriver::ModbusDriver(const std::vector<SensorSetup>& sensors)
    : profile_(decode::profile_of(sensors, "modbus")),
      endpoint_(endpoint_of(sensors.front(), *profile_.modbus)),
      sensors_(profile_, sensors),
      period_ns_(std::llround(1e9 / profile_.rate_hz)) {}

DeviceInfo ModbusDriver::open() {
  close();
  const bool tcp = !endpoint_.host.empty();
  context_.reset(
      tcp ? modbus_new_tcp_pi(endpoint_.host.c_str(), std::to_string(endpoint_.port).c_str())
          : modbus_new_rtu(endpoint_.serial_line.c_str(), endpoint_.baud, profile_.modbus->parity, 8, 1));
  if (!context_)
    throw DriverError(endpoint_.text + ": " + modbus_strerror(errno) + ": correct the sensor's device");
  modbus_set_slave(context_.get(), endpoint_.unit);
  set_time(modbus_set_response_timeout, context_.get(), kConnectPatience);
  if (modbus_connect(context_.get()) != 0) {
    const int error = errno;
    throw DriverError(
        endpoint_.text + ": " +
        (tcp ? why_unreachable(endpoint_.host, endpoint_.port, error)
             : modbus_strerror(error) + std::string(": is the adapter plugged in, and may slipd open it?")));
  }
  modbus_flush(context_.get());
  sensors_.reset();
  std::size_t longest = 0;
  for (const auto& rule : profile_.scan) longest = std::max(longest, rule.length);
  answer_.assign(longest, 0);
  refuse_what_is_refused();
  due_ns_ = monotonic_ns();
  next_ = 0;
  unanswered_ = 0;
  return {.description = profile_.description + " at " + endpoint_.text,
          .serial = "",
          .simulated = false,
          .sensors = sensors_.info()};
}

// Asks once for each read of a scan. A device that does not answer now may do so later.
void ModbusDriver::refuse_what_is_refused() {
  for (std::size_t rule = 0; rule < profile_.scan.size(); ++rule) {
    const RequestResult reply = request(rule, kAnswerPatience);
    if (reply == RequestResult::refused)
      throw DriverError(endpoint_.text + ": answers, but refuses register " +
                        std::to_string(profile_.scan[rule].id) + ": " + modbus_strerror(error_) +
                        ": wrong profile or device.unit, or the device is not ready");
    if (reply != RequestResult::answered) return;
  }
}

void ModbusDriver::close() noexcept {
  context_.reset();
}

// One request. The answer's registers become bytes in the order of transmission.
ModbusDriver::RequestResult ModbusDriver::request(std::size_t rule,
                                                  std::chrono::microseconds patience) noexcept {
  const decode::PacketRule& wanted = profile_.scan[rule];
  const auto count = static_cast<int>(wanted.length / 2);
  std::array<std::uint16_t, MODBUS_MAX_READ_REGISTERS> registers;
  set_time(modbus_set_response_timeout, context_.get(), patience);
  const auto first = static_cast<int>(wanted.id);
  const int got = profile_.modbus->function == 3
                      ? modbus_read_registers(context_.get(), first, count, registers.data())
                      : modbus_read_input_registers(context_.get(), first, count, registers.data());
  if (got == count) {
    for (std::size_t i = 0; i < wanted.length / 2; ++i) {
      answer_[2 * i] = static_cast<std::uint8_t>(registers[i] >> 8);
      answer_[2 * i + 1] = static_cast<std::uint8_t>(registers[i] & 0xFF);
    }
    return RequestResult::answered;
  }
  error_ = errno;
  modbus_flush(context_.get());  // a late answer must not answer the next request
  if (error_ == ETIMEDOUT) return RequestResult::late;
  // libmodbus' own error numbers: exceptions first, then malformed answers.
  if (error_ > MODBUS_ENOBASE && error_ <= EMBXGTAR) return RequestResult::refused;
  if (error_ >= MODBUS_ENOBASE) return RequestResult::malformed;
  return RequestResult::gone;
}

ReadResult ModbusDriver::read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept {
  if (const ReadResult waiting = sensors_.next_ready(); waiting.status == ReadStatus::frame) return waiting;
  const std::int64_t begun_ns = monotonic_ns();
  const std::int64_t give_up_ns = begun_ns + std::chrono::nanoseconds(timeout).count();
  if (begun_ns - due_ns_ > kLongestLagNs) due_ns_ = begun_ns;
  for (;;) {
    if (next_ == 0 && !sleep_until(due_ns_, give_up_ns)) return {ReadStatus::timeout, 0};
    // Waits for the answer even beyond the time-out, or it would arrive as the answer to the next request.
    const auto patience = std::max<std::chrono::nanoseconds>(
        kAnswerPatience, std::chrono::nanoseconds(give_up_ns - monotonic_ns()));
    if (next_ == 0) due_ns_ += period_ns_;
    const std::size_t rule = next_;
    const RequestResult reply =
        request(rule, std::chrono::duration_cast<std::chrono::microseconds>(patience));
    if (reply != RequestResult::answered) {
      next_ = 0;
      if (reply == RequestResult::gone) return {ReadStatus::disconnected, 0};
      // A device that refuses is there: open() says what it refuses.
      if (++unanswered_ >= kGoneAfter)
        return {reply == RequestResult::refused ? ReadStatus::changed : ReadStatus::disconnected, 0};
      return {reply == RequestResult::late ? ReadStatus::timeout : ReadStatus::corrupt, 0};
    }
    unanswered_ = 0;
    next_ = (rule + 1) % profile_.scan.size();
    const decode::PacketRule& answered = profile_.scan[rule];
    const ReadResult result =
        sensors_.take(answered.id, std::span(answer_).first(answered.length), monotonic_ns(), slots);
    if (result.status != ReadStatus::timeout) return result;
    if (monotonic_ns() >= give_up_ns) return {ReadStatus::timeout, 0};
  }
}

}  // namespace slipd::modbus
