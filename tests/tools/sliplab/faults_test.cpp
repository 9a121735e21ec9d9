// Faults of sensors are told, and no margin is far too safe because of one.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tools/sliplab/faults/measure.hpp"

namespace sliplab {
namespace {

using slipd::MethodChoice;

// Faults that leave the margin right, or that no frame shows: they need not be told, and their margins are
// counted in docs/reliability.md.
bool harmless(Fault fault) {
  switch (fault) {
    case Fault::swapped_axes:  // the margin depends on the resultant of shear
    case Fault::transposed:    // and not on the direction
    case Fault::drift:
    case Fault::delayed:
    case Fault::scale_1e3:  // beyond the scene's contacts on fine layouts only
    case Fault::weak_shear:
    case Fault::stuck_bit:
    case Fault::other_finger:
    case Fault::clipped_shear:  // where shear stays below the limit nothing is clipped
    case Fault::dead_row:       // off the contact
      return true;
    default:
      return false;
  }
}

std::vector<Fault> all_faults() {
  std::vector<Fault> all;
  for (std::size_t i = 1; i < kFaults; ++i) all.push_back(static_cast<Fault>(i));
  return all;
}

class FaultMatrix : public ::testing::TestWithParam<std::size_t> {};

TEST_P(FaultMatrix, TellsFaultsAndGivesNoMarginThatIsFarTooSafe) {
  FaultSetup setup;
  setup.grasps = GetParam() > 16 ? 4 : 20;
  setup.sensing.frame_s = 0.002;
  const auto method = GetParam() == 4 ? MethodChoice::fit : MethodChoice::moments;
  const auto lines =
      measure_faults(paper_chain(GetParam(), method, setup.sensing.noise), nullptr, all_faults(), setup);
  for (const FaultLine& line : lines) {
    EXPECT_EQ(line.false_alarms, 0U);
    if (harmless(line.fault)) continue;
    EXPECT_EQ(line.told, line.grasps) << name_of(line.fault);
    EXPECT_LE(line.too_safe, line.sound_too_safe) << name_of(line.fault) << " of " << line.answered;
  }
}

INSTANTIATE_TEST_SUITE_P(Sides, FaultMatrix, ::testing::Values(4, 16, 100));

}  // namespace
}  // namespace sliplab
