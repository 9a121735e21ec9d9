// Faults of sensors and their cables, put into frames of a sound sensor from one frame on.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string_view>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/numeric/random.hpp"

namespace lab {

enum class Fault : std::uint8_t {
  none,
  dead_shear_x,       // shear x reads 0
  dead_shear,         // both shears read 0
  stuck_shear_x,      // shear x keeps its values
  dead_normal,        // pressure reads 0
  dead_row,           // a row of taxels reads 0 in all channels, that of the contact's middle
  spike_5mpa,         // the taxel of the pad's middle reads 5 MPa
  spike_1e30,         // it reads 1e30 Pa
  far_100mpa,         // the last taxel reads 100 MPa
  stuck_bit,          // a bit of a taxel's pressure is stuck: 400 kPa more
  stuck_bit_channel,  // the same of all taxels
  not_a_number,       // a taxel's pressure is not a number
  scale_1e_6,         // all values are 1e-6 of what they should be
  scale_1e3,          // all values are 1000 times as large: a wrong unit
  scale_1e25,         // 1e25 times
  all_equal,          // all taxels of a channel read its mean
  frozen,             // the frame stays
  repeated_block,     // the last twenty frames again and again
  doubled,            // each frame comes twice, the second time under a number of its own
  delayed,            // each frame comes ten frames late under the present time
  time_stands,        // the time stamp stays
  clipped_shear,      // shears are limited to 5 kPa
  clipped_normal,     // pressure is limited to half its peak
  swapped_axes,       // shear x and y are exchanged
  transposed,         // rows and columns are exchanged
  other_finger,       // another contact's frames
  drift,              // pressure drifts by up to 2 kPa a second, another way for each taxel
  weak_shear,         // shear x reads a tenth of what it should
  turned_shear_x,     // shear x has the other sign
  dead_column,        // a column of taxels reads 0 in all channels, that of the contact's middle
  stuck_shear_bit,    // a bit of a taxel's shear x is stuck: 400 kPa more
  noisy_shear_x,      // shear x has noise of 20 kPa
  lost_gains,         // each taxel reads by up to 30 % too much or too little, another one each
  lost_zeros          // each taxel's pressure has an offset of up to 20 kPa, another one each
};
inline constexpr std::size_t kFaults = 34;
std::string_view name_of(Fault fault) noexcept;

// Puts one fault into the frames of one grasp. Not thread-safe.
class FaultInjector {
 public:
  // `first`: number of the first frame with the fault, from 1.
  FaultInjector(Fault fault, const slipd::TaxelLayout& layout, std::uint64_t first,
                const slipd::RandomStream& random);

  // Called for each frame in order. `other`: a frame of another contact, used by other_finger.
  void spoil(slipd::FrameSlot& frame, const slipd::Frame& other);

 private:
  struct Kept {
    std::int64_t time_ns = 0;
    std::array<std::vector<float>, 3> values;
  };
  void keep(const slipd::FrameSlot& frame, std::size_t most);
  static void put(const Kept& kept, slipd::FrameSlot& frame);
  void spoil_taxels(slipd::FrameSlot& frame) const;
  void spoil_line(slipd::FrameSlot& frame) const;
  void spoil_calibration(slipd::FrameSlot& frame) const;
  void spoil_channels(slipd::FrameSlot& frame);
  void spoil_course(slipd::FrameSlot& frame, const slipd::Frame& other);

  Fault fault_;
  const slipd::TaxelLayout& layout_;
  std::uint64_t first_;
  slipd::RandomStream random_;
  std::deque<Kept> kept_;
  std::uint64_t since_ = 0;  // frames with the fault
  float limit_pa_ = 0;       // of clipped_normal
};

}  // namespace lab
