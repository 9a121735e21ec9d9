// The board in shared memory, as the daemon writes it and readers map it: a header, then one slot for each
// sensor and one for each grasp, in the order of the configuration. docs/clients.md states every byte. All
// numbers are little-endian; a machine that is not cannot build it.
//
// One process writes (the daemon's estimate thread; io before that thread learns of the memory, and
// `closed`). Readers map the memory read-only, so that none of them can change what another one reads.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "core/frame/latest.hpp"

namespace slipd::board_layout {

static_assert(std::endian::native == std::endian::little);
// Otherwise an atomic could be a lock in the memory of one process.
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);
static_assert(std::atomic<std::uint32_t>::is_always_lock_free);

inline constexpr std::array<char, 8> kMagic{'s', 'l', 'i', 'p', 'd', 'b', 'r', 'd'};
// Rises when a field changes its place or meaning. Fields that are appended in a reserved place leave it.
inline constexpr std::uint32_t kVersion = 1;
// Longest time between two heartbeats of a running slipd, ns. Shorter: the estimate thread of idle sensors
// wakes more often. Longer: a stopped slipd is noticed later.
inline constexpr std::int64_t kHeartbeatPeriodNs = 20'000'000;
// An unknown number.
inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
// Record::sliding if the sensor or contact cannot show it.
inline constexpr std::uint8_t kSlidingUnknown = 255;
// Record::alert and Record::health where there was no frame (core/estimate/estimate.hpp, Alert and Health).
inline constexpr std::uint8_t kAlertUnknown = 3, kHealthUnknown = 255;
// Record::first_sensor if there is none.
inline constexpr std::uint32_t kNoSensor = 0xFFFF'FFFF;
// Number of the state stale (core/estimate/estimate.hpp, State), which a slot has before its first record.
inline constexpr std::uint8_t kStale = 6;

// One estimate of a sensor or grasp; SI units. Unknown numbers are NaN.
struct Record {
  // Of the frame, as the device counts; of a grasp the sum over its sensors.
  std::uint64_t sequence = 0;
  // Of the sample, ns, CLOCK_MONOTONIC; of a grasp the oldest of its sensors. 0: there was no frame.
  std::int64_t time_ns = 0;
  // When the estimate was made, ns, CLOCK_MONOTONIC.
  std::int64_t published_ns = 0;
  // Records of this slot up to and with this one; a reader that sees it rise by more than one missed some.
  std::uint64_t number = 0;
  // Safety margin, 0 to 1; NaN unless state is ok.
  double gamma = kUnknown;
  // Standard deviation of gamma.
  double sigma = kUnknown;
  // The margin that holds with 95 % confidence while friction stays, 0 to 1.
  double gamma_low = kUnknown;
  // Coefficient of friction, learnt or given.
  double friction = kUnknown;
  // Its standard deviation.
  double friction_sigma = kUnknown;
  // Normal force, N.
  double normal_n = kUnknown;
  // Tangential force, N.
  double shear_n = kUnknown;
  // Torque about the contact's normal, N m.
  double torque_nm = kUnknown;
  // Its standard deviation, N m.
  double torque_sigma_nm = kUnknown;
  // Centre of the contact, m.
  double center_x_m = kUnknown;
  // Centre of the contact, m.
  double center_y_m = kUnknown;
  // Radius of the contact, m.
  double radius_m = kUnknown;
  // Radius over the skin's.
  double a_over_r = kUnknown;
  // Forecast, s.
  double time_to_slip_s = kUnknown;
  // Normal force to add for the configured target margin, N; negative: less suffices.
  double grip_increase_n = kUnknown;
  // Its standard deviation, N.
  double grip_increase_sigma_n = kUnknown;
  // How long `sliding` has been what it is, s.
  double sliding_for_s = kUnknown;
  // Of a grasp: the least margin of its sensors. NaN for a sensor.
  double first_gamma = kUnknown;
  // Of a simulated sensor: the margin that is true.
  double truth_gamma = kUnknown;
  // Of a simulated sensor: the friction that is true.
  double truth_friction = kUnknown;
  // Numbers of State, Alert, AlertCause, Method, Health and Sliding; docs/clients.md lists them.
  std::uint8_t state = kStale;
  std::uint8_t alert = kAlertUnknown;
  std::uint8_t alert_cause = 0;
  std::uint8_t method = 0;
  std::uint8_t health = kHealthUnknown;
  std::uint8_t sliding = kSlidingUnknown;
  // 1: a simulated sensor, or a grasp of one.
  std::uint8_t simulated = 0;
  std::uint8_t reserved_byte = 0;
  // Of a grasp: the slot of the sensor that slides first; kNoSensor: unknown.
  std::uint32_t first_sensor = kNoSensor;
  std::uint32_t reserved_word = 0;
  std::array<std::uint64_t, 5> reserved{};
};

// One sensor or grasp.
struct alignas(64) Slot {
  // Zeros after its end; at least one.
  std::array<char, 64> name{};
  // 0: a sensor; 1: a grasp.
  std::uint32_t kind = 0;
  // Records published, modulo 2^32: the futex to wait on. Release after the record was stored, so that who
  // sees the number finds that record or a newer one.
  std::atomic<std::uint32_t> published{0};
  std::array<std::uint64_t, 7> reserved{};
  // The newest record, as a seqlock of two copies: core/frame/latest.hpp argues it.
  Latest<Record> latest;
};

// The beginning of the memory.
struct alignas(64) Header {
  std::array<char, 8> magic = kMagic;
  std::uint32_t version = kVersion;
  // Bytes of the header, of each slot, and of a record in it.
  std::uint32_t header_bytes = 0;
  std::uint32_t slot_bytes = 0;
  std::uint32_t record_bytes = sizeof(Record);
  // Slots of sensors, then of grasps.
  std::uint32_t sensors = 0;
  std::uint32_t grasps = 0;
  // CLOCK_REALTIME at which the memory was made, ns: another number for each start and each reload.
  std::uint64_t generation = 0;
  // kHeartbeatPeriodNs.
  std::int64_t heartbeat_period_ns = kHeartbeatPeriodNs;
  // Of slipd, for people: it may be of another PID namespace.
  std::uint32_t pid = 0;
  std::uint32_t reserved_word = 0;
  std::uint64_t reserved = 0;
  // When the estimate thread that is furthest behind last went round, ns, CLOCK_MONOTONIC; 0: one has not yet
  // since the memory was made.
  // Relaxed: no other memory is read because of it.
  alignas(64) std::atomic<std::int64_t> heartbeat_ns{0};
  // 1: slipd has stopped or taken up another configuration; attach anew. Release and acquire: after it no
  // record changes.
  std::atomic<std::uint32_t> closed{0};
};

// Where docs/clients.md and clients that cannot link have them.
static_assert(sizeof(Record) == 248 && std::is_trivially_copyable_v<Record> &&
              offsetof(Record, gamma) == 32 && offsetof(Record, truth_friction) == 184 &&
              offsetof(Record, state) == 192 && offsetof(Record, first_sensor) == 200);
static_assert(std::is_standard_layout_v<Header> && sizeof(Header) == 128 &&
              offsetof(Header, generation) == 32 && offsetof(Header, pid) == 48 &&
              offsetof(Header, heartbeat_ns) == 64 && offsetof(Header, closed) == 72);
static_assert(sizeof(Latest<Record>) == 576 && sizeof(Slot) == 704 && alignof(Slot) == 64);

// Bytes of the memory for so many sensors and grasps.
constexpr std::size_t bytes_for(std::size_t sensors, std::size_t grasps) noexcept {
  return sizeof(Header) + (sensors + grasps) * sizeof(Slot);
}

}  // namespace slipd::board_layout
