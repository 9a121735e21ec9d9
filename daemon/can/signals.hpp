// Position and scale of each signal in slipd's CAN messages. config/slipd.dbc is the definition; a test
// compares both. All signals are unsigned, little-endian (Intel).
#pragma once

#include <array>
#include <cstdint>

namespace slipd::can {

// One signal.
struct Signal {
  // As in the DBC file.
  const char* name;
  // Number of its least significant bit, 0 to 63.
  unsigned start;
  // Number of bits.
  unsigned length;
  // Value of one count, in the unit of the DBC file.
  double scale;
  // Value of count 0, in the same unit.
  double offset = 0;
};

// Count of a 16 bit signal that is not available.
inline constexpr std::uint64_t kNotAvailable = 0xFFFF;
// Version of these messages, in the heartbeat.
inline constexpr std::uint64_t kProtocol = 1;

// The last signals of every message.
inline constexpr Signal kCounter{"Counter", 52, 4, 1};
inline constexpr Signal kCrc8{"Crc8", 56, 8, 1};

namespace estimate {
inline constexpr Signal kGamma{"Gamma", 0, 16, 1e-4};
inline constexpr Signal kFriction{"Friction", 16, 16, 1e-4};
inline constexpr Signal kState{"State", 32, 4, 1};
inline constexpr Signal kAlert{"Alert", 36, 2, 1};
inline constexpr Signal kSimulated{"Simulated", 38, 1, 1};
inline constexpr Signal kImplausible{"Implausible", 39, 1, 1};
inline constexpr Signal kSequence{"Sequence", 40, 12, 1};
inline constexpr std::array kAll{kGamma,       kFriction, kState,   kAlert, kSimulated,
                                 kImplausible, kSequence, kCounter, kCrc8};
}  // namespace estimate

namespace alert {
inline constexpr Signal kGamma{"Gamma", 0, 16, 1e-4};
inline constexpr Signal kGripIncrease_n{"GripIncrease", 16, 16, 0.01};
inline constexpr Signal kTimeToSlip_ms{"TimeToSlip", 32, 16, 1};
inline constexpr Signal kAlert{"Alert", 48, 2, 1};
inline constexpr Signal kSimulated{"Simulated", 50, 1, 1};
inline constexpr Signal kCause{"Cause", 51, 1, 1};
inline constexpr std::array kAll{kGamma,     kGripIncrease_n, kTimeToSlip_ms, kAlert,
                                 kSimulated, kCause,          kCounter,       kCrc8};
}  // namespace alert

namespace sliding {
inline constexpr Signal kSlidingFor_ms{"SlidingFor", 0, 16, 1};
// A count of 32767 is no torque.
inline constexpr Signal kTorque_nmm{"Torque", 16, 16, 0.1, -3276.7};
inline constexpr Signal kSliding{"Sliding", 32, 3, 1};
inline constexpr Signal kAlert{"Alert", 36, 2, 1};
inline constexpr Signal kSimulated{"Simulated", 38, 1, 1};
inline constexpr Signal kSequence{"Sequence", 40, 12, 1};
inline constexpr std::array kAll{kSlidingFor_ms, kTorque_nmm, kSliding, kAlert,
                                 kSimulated,     kSequence,   kCounter, kCrc8};
// Count of kSliding where it is not known whether the object slides.
inline constexpr std::uint64_t kSlidingNotAvailable = 7;
}  // namespace sliding

namespace heartbeat {
inline constexpr Signal kProtocolVersion{"Protocol", 0, 8, 1};
inline constexpr Signal kMessages{"Messages", 8, 8, 1};
inline constexpr Signal kUptime_s{"Uptime", 16, 24, 1};
inline constexpr Signal kStopping{"Stopping", 40, 1, 1};
inline constexpr std::array kAll{kProtocolVersion, kMessages, kUptime_s, kStopping, kCounter, kCrc8};
}  // namespace heartbeat

}  // namespace slipd::can
