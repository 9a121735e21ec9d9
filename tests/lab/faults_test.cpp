// Faults of sensors are reported, and no margin is far too safe because of one.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "lab/faults/measure.hpp"

namespace lab {
namespace {

using slipd::MethodChoice;

// Faults that leave the margin right, or that no frame shows: they need not be reported, and their margins
// are counted in docs/reliability.md.
bool harmless(Fault fault) {
  switch (fault) {
    case Fault::swapped_axes:  // the margin depends on the resultant of shear
    case Fault::transposed:    // and not on the direction
    case Fault::drift:
    case Fault::delayed:
    case Fault::scale_1e3:  // beyond the scene's contacts on fine layouts only
    case Fault::weak_shear:
    case Fault::turned_shear_x:
    case Fault::dead_column:
    case Fault::stuck_shear_bit:
    case Fault::noisy_shear_x:
    case Fault::lost_gains:
    case Fault::lost_zeros:
    case Fault::stuck_bit:
    case Fault::other_finger:
    case Fault::clipped_shear:  // where shear stays below the limit nothing is clipped
    case Fault::dead_row:       // off the contact
      return true;
    default:
      return false;
  }
}

// Of the margins that are given, those that may be too safe beyond those of a sound sensor: what is left of a
// frame says a little less than the whole.
constexpr double kMore = 0.01;

std::vector<Fault> all_faults() {
  std::vector<Fault> all;
  for (std::size_t i = 1; i < kFaults; ++i) all.push_back(static_cast<Fault>(i));
  return all;
}

class FaultMatrix : public ::testing::TestWithParam<std::size_t> {};

TEST_P(FaultMatrix, TellsFaultsAndGivesNoMarginThatIsFarTooSafe) {
  FaultSetup setup;
  setup.grasps = GetParam() > 16 ? 2 : 8;
  setup.sensing.frame_s = 0.002;
  const auto method = GetParam() == 4 ? MethodChoice::fit : MethodChoice::moments;
  const auto lines =
      measure_faults({paper_chain(GetParam(), method, setup.sensing.noise), nullptr}, all_faults(), setup);
  ASSERT_EQ(lines.size(), kFaults - 1);
  for (const FaultLine& line : lines) {
    EXPECT_EQ(line.false_alarms, 0U);
    EXPECT_GT(line.sound_answered, 100U) << "margins of the sound sensor";
    if (harmless(line.fault)) continue;
    EXPECT_EQ(line.reported, line.grasps) << name_of(line.fault);
    EXPECT_LE(static_cast<double>(line.too_safe),
              static_cast<double>(line.sound_too_safe) + kMore * static_cast<double>(line.answered))
        << name_of(line.fault);
  }
}

class FaultMatrixOfPresets : public ::testing::TestWithParam<slipd::sim::Preset> {};

// What a sensor of few large taxels shows of itself at once, whatever it holds.
TEST_P(FaultMatrixOfPresets, ReportsChannelsThatDieAndFramesThatRepeatAndNoSoundFrame) {
  const PresetBench bench = bench_of(GetParam());
  FaultSetup setup;
  setup.grasps = 6;
  const auto lines =
      measure_faults(bench, chain_of(bench, std::nullopt),
                     {Fault::dead_shear, Fault::dead_shear_x, Fault::dead_normal, Fault::frozen,
                      Fault::repeated_block, Fault::all_equal, Fault::not_a_number},
                     setup);
  ASSERT_EQ(lines.size(), 7U);
  for (const FaultLine& line : lines) {
    EXPECT_GT(line.sound_answered, 0U);
    EXPECT_EQ(line.false_alarms, 0U);
    EXPECT_EQ(line.reported, line.grasps) << name_of(line.fault);
    EXPECT_LE(line.too_safe, line.sound_too_safe) << name_of(line.fault);
  }
}

INSTANTIATE_TEST_SUITE_P(Presets, FaultMatrixOfPresets,
                         ::testing::Values(slipd::sim::Preset::pillars, slipd::sim::Preset::magnetic_skin));

INSTANTIATE_TEST_SUITE_P(Sides, FaultMatrix, ::testing::Values(4, 16, 100));

}  // namespace
}  // namespace lab
