// What a sensor reads while nothing touches it: its bias, and how much it flickers about it. Made by
// BiasEstimator, kept on disk by the daemon.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace slipd {

// On whose word nothing touched the sensor.
enum class BiasOrigin : std::uint8_t {
  none,     // there is no zero
  command,  // somebody's, who asked for it
  no_load   // its own: it read what it has to read without load
};

std::string_view to_string(BiasOrigin) noexcept;  // "none", "command", "no_load"

// Pascal, three values a taxel: first all normal pressures, then all shears along x, then along y.
struct Bias {
  std::vector<float> bias_pa;   // mean of the frames without load, before any gain
  std::vector<float> noise_pa;  // standard deviation of one of these frames
  BiasOrigin origin = BiasOrigin::none;
  std::int64_t taken_ns = 0;      // CLOCK_MONOTONIC; below 0: before this machine was started
  std::int64_t confirmed_ns = 0;  // as above: when it was last seen to hold
  // What the sensor read when it was last seen, as bias_pa; empty: not known. A load that is still held when
  // the sensor is back tells that it is the same sensor.
  std::vector<float> last_pa = {};
};

// Why a zero that is there is not used.
enum class BiasDoubt : std::uint8_t {
  none,       // it is used
  elsewhere,  // the sensor was away, and now reads neither as without load nor as before
  below       // the sensor reads far below the zero, which no contact can cause
};

std::string_view to_string(BiasDoubt) noexcept;  // "none", "elsewhere", "below"

// How it went with a zero that was asked for.
enum class BiasResult : std::uint8_t {
  none,        // it was not asked for, or the answer is still to come
  taken,       // the zero is new
  moving,      // refused: the reading does not stand still
  in_contact,  // refused: the reading looks like a contact
  gone         // the device went away meanwhile
};

std::string_view to_string(BiasResult) noexcept;  // "none", "taken", …

// What others may know of a sensor's zero. Trivially copyable, so that it crosses threads by plain copies.
struct BiasReport {
  std::int64_t taken_ns = 0, confirmed_ns = 0;    // as in Bias
  float noise_normal_pa = 0, noise_shear_pa = 0;  // root mean square over the taxels
  float drift_pa = 0;                             // the bias's largest way since it was taken
  std::uint32_t asked = 0;                        // the request last heard of
  std::uint32_t answered = 0;                     // the request last answered
  std::uint32_t taken = 0;                        // how many zeros were taken here
  BiasOrigin origin = BiasOrigin::none;
  BiasResult answer = BiasResult::none;  // to `answered`
  BiasDoubt doubt = BiasDoubt::none;     // anything else: frames are marked as not zeroed
  float off_pa = 0;                      // with a doubt: mean distance of normal pressure from the zero
  bool restored = false;                 // it comes from disk
  bool free = false;                     // nothing touched the sensor a moment ago
};

}  // namespace slipd
