// Detection of slip on recordings of real sensors that slipd did not make; tests/data has their sources and
// licences. They are too few to measure with: `slipd-bench` does that.
#include <gtest/gtest.h>

#include "tools/sliplab/replay/label.hpp"
#include "tools/sliplab/replay/run.hpp"

namespace sliplab {
namespace {

const std::string kRealData = SLIPD_SOURCE_DIR "/tests/data/";
const std::string kShippedScenes = SLIPD_SOURCE_DIR "/config/scenes/";

ReplayRun skin(const std::string& sensor, const std::string& folder) {
  return replay(kShippedScenes + "uskin-4x4.json", sensor,
                {kRealData + "uskin/" + folder + "/xela_" + sensor + ".csv"})
      .at(0);
}

TEST(RealMagneticSkin, HasItsSlipDetectedAboutWhenTheCameraSeesIt) {
  for (const std::string sensor : {"sensor1", "sensor2"}) {
    const ReplayRun run = skin(sensor, "slip");
    EXPECT_EQ(run.rows.size(), 259U);
    const LabelScore score = score_alerts(run, read_labels(kRealData + "uskin/slip/slip_label.csv", run));
    ASSERT_TRUE(score.lead_s) << sensor;
    EXPECT_LT(*score.lead_s, 0.5) << sensor;
    EXPECT_GT(*score.lead_s, -0.4) << sensor;
    EXPECT_EQ(score.false_alerts, 0U) << sensor;
  }
}

TEST(RealMagneticSkin, IsSilentWhileAnArmMovesAnObjectThatSticks) {
  for (const ReplayRow& row : skin("sensor2", "still").rows)
    ASSERT_NE(row.estimate.alert, slipd::Alert::slip) << "row " << row.row;
}

// One of six may be wrong: the design value is false alarms per hour, not per sequence of three seconds.
TEST(RealRawMagnetometers, TellSequencesWithASlipFromThoseWithout) {
  int right = 0;
  for (const auto& [name, slips] : {std::pair{"000", true},
                                    {"002", true},
                                    {"004", true},
                                    {"086", false},
                                    {"088", false},
                                    {"090", false}}) {
    bool slid = false;
    for (const ReplayRun& run :
         replay(kShippedScenes + "eflesh.json", "", {kRealData + "eflesh/seq_" + name + ".csv"})) {
      for (const ReplayRow& row : run.rows) slid = slid || slipd::slides(row.estimate.sliding);
    }
    right += slid == slips ? 1 : 0;
  }
  EXPECT_GE(right, 5);
}

}  // namespace
}  // namespace sliplab
