// What is wrong with a frame, as a word that travels with its estimate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace slipd {

// Why a frame, or a sensor, is not believed. `good`: nothing speaks against it. Checks that need one frame
// are marked 1, those that compare frames are marked n.
enum class Health : std::uint8_t {
  good,
  not_finite,     // 1: a value is not a number, or so large that sums of it are not
  full_scale,     // 1: several taxels are beyond the sensor's full scale
  spike,          // 1: one taxel is far above what its neighbours can support; it is left out
  uniform,        // 1: all taxels read the same pressure
  wrong_scale,    // 1, n: the force does not fit the contact's size, or fell to nothing in one frame
  saturated,      // n: taxels stand at a rail, so that forces are larger than what is read
  repeated,       // n: the frame is the one before, of a sensor whose frames differ
  frozen,         // n: frames repeat
  dead_normal,    // n: the normal channel stands still while others move
  dead_shear_x,   // n: shear along x stands still while others move
  dead_shear_y,   // n: shear along y stands still while others move
  dead_row,       // n: a row or column of taxels stands still while others move
  time,           // n: the frame's time is not after the last one's
  jump,           // n: the contact is somewhere else than a frame ago, or all pressures rose at once
  unexplained,    // n: the method refuses frames, and the forces' course does not say why
  noisy,          // n: one channel has become much noisier than it was
  unknown = 255,  // there is no frame, or none that could be checked
};

// `good` and what is found; without `unknown`.
inline constexpr std::size_t kHealths = 17;

// Whether something speaks against the frame.
constexpr bool is_implausible(Health health) noexcept {
  return health != Health::good && health != Health::unknown;
}

// As on the socket: "good", "not_finite", …, "unknown".
std::string_view to_string(Health health) noexcept;

// For people: "implausible: shear x is dead". Static text that ends with a zero.
const char* describe(Health health) noexcept;

}  // namespace slipd
