// Recordings through the daemon's chain: each row of a file has its line, whatever the row holds, and labels
// are scored as they stand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "driver_api/driver.hpp"
#include "drivers/sim/simulated_sensor.hpp"
#include "tests/support/csv.hpp"
#include "tests/support/temp_folder.hpp"
#include "tools/sliplab/command.hpp"
#include "tools/sliplab/replay/label.hpp"
#include "tools/sliplab/replay/run.hpp"
#include "tools/sliplab/replay/table.hpp"

namespace sliplab {
namespace {

using slipd::testing::row_fields;

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

constexpr std::size_t kRate = 100;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

// A finger of 3 x 3 pillars in newtons, 100 rows a second: no contact, a grip of 5 N, a load up to `load` of
// what holds.
std::vector<std::string> pillar_rows(double load) {
  using namespace slipd;
  const auto layout = TaxelLayout::grid(3, 3, 0.007);
  sim::SensorSettings grasp;
  grasp.preset = sim::Preset::pillars;
  grasp.skin = {std::numeric_limits<double>::infinity(), 1e6, 0.49};
  constexpr std::int64_t kMs = 1'000'000;
  grasp.cycle = {{500 * kMs, sim::Ramp{0, 0}, {}, sim::Ramp{0, 0}, 0.5},
                 {100 * kMs, sim::Ramp{0, 5}, {}, {}, {}},
                 {900 * kMs, {}, {}, {}, {}},
                 {500 * kMs, {}, {}, sim::Ramp{0, load}, {}},
                 {1000 * kMs, {}, {}, {}, {}}};
  sim::SimulatedSensor sensor(layout, grasp);
  std::vector<float> memory(27);
  FrameSlot slot;
  slot.normal_pa = std::span(memory).first(9);
  slot.shear_x_pa = std::span(memory).subspan(9, 9);
  slot.shear_y_pa = std::span(memory).last(9);
  std::vector<std::string> rows;
  for (int i = 0; i < 290; ++i) {
    sensor.advance(std::chrono::milliseconds(10));
    sensor.sample(slot);
    std::ostringstream row;
    for (std::size_t k = 0; k < 9; ++k) {
      const double a = layout.area_m2();
      row << (k > 0 ? "," : "") << a * slot.shear_x_pa[k] << ',' << a * slot.shear_y_pa[k] << ','
          << a * slot.normal_pa[k];
    }
    rows.push_back(row.str());
  }
  return rows;
}

// Rows with a constant on each channel, as of a sensor that has a zero.
std::vector<std::string> offset(const std::vector<std::string>& rows) {
  std::vector<std::string> shifted;
  for (const std::string& row : rows) {
    std::string& text = shifted.emplace_back();
    double by = 100;
    for (const std::string& field : row_fields(row)) {
      text += (text.empty() ? "" : ",") + std::to_string(std::stod(field) + by);
      by += 3;
    }
  }
  return shifted;
}

std::string csv_of(const std::vector<std::string>& rows, int first = 1) {
  std::string text;
  for (int k = first; k < first + 9; ++k) {
    const std::string name = "txl" + std::to_string(k);
    text += (k > first ? "," : "") + name + "_x," + name + "_y," + name + "_z";
  }
  for (const std::string& row : rows) text += "\n" + row;
  return text + "\n";
}

class Replay : public ::testing::Test {
 protected:
  // `more`: further members of the sensor, each with a leading comma.
  std::filesystem::path scene(const std::string& options = R"("unit": "N")",
                              const std::string& more = "") const {
    return folder_.write("scene.json",
                         R"({ "sensors": [ { "name": "finger", "driver": "replay", "rate_hz": 100,
      "layout": { "grid": [3, 3], "pitch_mm": 7 }, "skin": { "radius_mm": "flat", "modulus_mpa": 1 })" +
                             more + R"(,
      "options": { "file": "none.csv", )" +
                             options + R"( } } ],
      "objects": [ { "normal_n": [1, 20], "friction": [0.3, 1] } ] })");
  }
  ReplayRun run(const std::string& csv, const std::string& options = R"("unit": "N")") const {
    return replay(scene(options), "", {folder_.write("file.csv", csv)}).at(0);
  }
  const slipd::testing::TempFolder folder_;
};

TEST_F(Replay, GivesEveryRowItsLineWithItsNumberFromZero) {
  auto rows = pillar_rows(0.3);
  const auto csv = lines_of(estimates_csv({run(csv_of(rows))}));
  ASSERT_EQ(csv.size(), rows.size() + 1);
  EXPECT_EQ(
      csv[0],
      "sensor,time_s,seq,state,gamma,gamma_low,sigma,friction,friction_sigma,normal_n,shear_n,torque_nmm,"
      "turned_deg,turned_sigma_deg,sliding,alert,alert_cause,displacement_mm,contact,slide_evidence");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto fields = row_fields(csv[i + 1]);
    ASSERT_EQ(fields.size(), 20U) << csv[i + 1];
    EXPECT_EQ(fields[0], "finger");
    EXPECT_NEAR(std::stod(fields[1]), static_cast<double>(i) / kRate, 1e-6);
    EXPECT_EQ(fields[2], std::to_string(i));
  }
}

TEST_F(Replay, LeavesEmptyWhatIsNotKnown) {
  const auto csv = lines_of(estimates_csv({run(csv_of(pillar_rows(0.3)))}));
  const auto& names = row_fields(csv[0]);
  const auto column = [&](const char* name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  std::size_t contact = 0;
  for (std::size_t i = 1; i < csv.size(); ++i) {
    const auto fields = row_fields(csv[i]);
    EXPECT_EQ(fields[column("state")] == "ok", !fields[column("gamma")].empty()) << csv[i];
    EXPECT_EQ(fields[column("alert")] == "none", fields[column("alert_cause")].empty()) << csv[i];
    if (fields[column("state")] == "no_contact") {
      for (const char* name : {"gamma", "sigma", "gamma_low", "sliding"})
        EXPECT_EQ(fields[column(name)], "") << csv[i];
    }
    contact += fields[column("state")] != "no_contact" && !fields[column("normal_n")].empty() ? 1 : 0;
    EXPECT_THAT(csv[i], Not(HasSubstr("nan")));
  }
  EXPECT_GT(contact, 200U) << "2.4 s of contact";
}

TEST_F(Replay, SaysWhereAFileEndsThatCannotBeReadOn) {
  auto rows = pillar_rows(0.3);
  rows[100] = "1,2,three";
  const ReplayRun played = run(csv_of(rows));
  EXPECT_EQ(played.rows.size(), 100U);
  EXPECT_THAT(played.fault, HasSubstr("102"));
}

TEST_F(Replay, ReadsNewtonsAsTheForcesThatTheyAre) {
  const ReplayRun played = run(csv_of(pillar_rows(0)));
  EXPECT_NEAR(played.rows[140].estimate.normal_n.value(), 5, 0.5);
  // The same numbers as pascal on 49 mm^2 are no contact.
  const ReplayRun as_pascal = run(csv_of(pillar_rows(0)), R"("unit": "Pa")");
  EXPECT_LT(as_pascal.rows[140].estimate.normal_n.value_or(0), 0.01);
}

TEST_F(Replay, OfRawCountsTellsSlidingAndNoMargin) {
  // Magnetometers read far from 0 without load, each its own value.
  const ReplayRun played = run(csv_of(offset(pillar_rows(0.3))), R"("unit": "raw")");
  bool told = false;
  for (const ReplayRow& row : played.rows) {
    EXPECT_EQ(row.estimate.state, slipd::State::unzeroed);
    EXPECT_FALSE(row.estimate.gamma || row.estimate.normal_n || row.estimate.friction);
    told = told || row.estimate.sliding;
  }
  EXPECT_TRUE(told);
}

TEST_F(Replay, TakesTheTaxelsThatAreNamedInThatOrder) {
  const auto rows = pillar_rows(0.3);
  // Two fingers in one file: the second has the columns txl10 …; its first and last pillars change places.
  std::vector<std::string> both;
  for (const std::string& row : rows)
    both.push_back("0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0," + row);
  std::string text = lines_of(csv_of({}))[0] + "," + lines_of(csv_of({}, 10))[0];
  for (const std::string& row : both) text += "\n" + row;
  const ReplayRun second =
      run(text + "\n", R"("unit": "N", "taxels": ["txl10", "txl11", "txl12", "txl13", "txl14",
    "txl15", "txl16", "txl17", "txl18"])");
  const ReplayRun alone = run(csv_of(rows));
  ASSERT_EQ(second.rows.size(), alone.rows.size());
  for (std::size_t i = 0; i < alone.rows.size(); ++i) {
    EXPECT_EQ(second.rows[i].estimate.normal_n, alone.rows[i].estimate.normal_n) << i;
    EXPECT_EQ(second.rows[i].estimate.gamma, alone.rows[i].estimate.gamma) << i;
  }
  EXPECT_ANY_THROW(run(text + "\n")) << "columns of more taxels than the layout has, and no names";
}

TEST_F(Replay, TakesTheZeroFromTheFirstRowsWhereThatIsAskedFor) {
  const auto rows = pillar_rows(0.3);
  const ReplayRun own = run(csv_of(offset(rows)), R"("unit": "N", "zero_from_s": 0.4)");
  const ReplayRun plain = run(csv_of(rows));
  ASSERT_EQ(own.rows.size(), plain.rows.size());
  for (const std::size_t held : {140U, 250U}) {
    EXPECT_NEAR(own.rows[held].estimate.normal_n.value(), plain.rows[held].estimate.normal_n.value(), 0.05);
    EXPECT_NEAR(own.rows[held].estimate.shear_n.value(), plain.rows[held].estimate.shear_n.value(), 0.05);
  }
  EXPECT_EQ(own.rows[20].estimate.state, slipd::State::no_contact);
}

TEST_F(Replay, SaysThatThereAreNoRowsToTakeAZeroFrom) {
  std::string missing;
  for (int i = 0; i < 27; ++i) missing += i == 0 ? "NA" : ",NA";
  try {
    run(csv_of({missing, missing}), R"("unit": "N", "zero_from_s": 0.4)");
    FAIL() << "a zero of nothing";
  } catch (const slipd::DriverError& error) {
    EXPECT_THAT(error.what(), HasSubstr("zero_from_s"));
    EXPECT_THAT(error.what(), HasSubstr("file.csv"));
  }
}

TEST_F(Replay, CountsRowsThatRepeatTheOneBefore) {
  const auto rows = pillar_rows(0.3);
  std::vector<std::string> often;
  for (const std::string& row : rows) often.insert(often.end(), 4, row);
  EXPECT_EQ(summarize(run(csv_of(rows))).repeated, 0U);
  EXPECT_EQ(summarize(run(csv_of(often))).repeated, 3 * rows.size());
}

// The rows with `time_of` the row's number as time.
template <class F>
std::string timed_csv(const std::vector<std::string>& rows, F time_of) {
  std::vector<std::string> lines = lines_of(csv_of(rows));
  lines.front() = "time," + lines.front();
  std::string text = lines.front();
  for (std::size_t i = 1; i < lines.size(); ++i)
    text += "\n" + std::to_string(time_of(static_cast<double>(i))) + "," + lines[i];
  return text + "\n";
}

TEST_F(Replay, TellsWhatIsWrongWithTheTimesOfAFile) {
  const auto rows = pillar_rows(0.3);
  const auto said = [&](auto time_of) {
    const ReplayRun played = run(timed_csv(rows, time_of));
    return remarks_on_time(played, summarize(played));
  };
  EXPECT_THAT(said([](double row) { return row / 100; }), IsEmpty());
  EXPECT_THAT(said([](double row) { return row / 60; }), IsEmpty()) << "less than a factor of 3";
  EXPECT_THAT(said([](double) { return 7; }), ElementsAre(HasSubstr("not later than the row before: 289,")));
  EXPECT_THAT(said([](double row) { return row < 100 ? row / 100 : row / 100 - 0.5; }),
              ElementsAre(HasSubstr("not later than the row before: 1,")));
  EXPECT_THAT(said([](double row) { return 10 * row; }),
              ElementsAre(StartsWith("by their times 0.1 rows come a second, by rate_hz 100")))
      << "in ms";
}

TEST_F(Replay, HasNoRemarkOnAFileWithoutTimes) {
  const ReplayRun played = run(csv_of(pillar_rows(0.3)));
  EXPECT_THAT(remarks_on_time(played, summarize(played)), IsEmpty());
}

TEST_F(Replay, GivesAGraspOfTheSceneRowsOfItsOwn) {
  const std::string finger =
      R"("driver": "replay", "rate_hz": 100, "layout": { "grid": [3, 3], "pitch_mm": 7 },
      "skin": { "radius_mm": "flat", "modulus_mpa": 1 }, "options": { "file": ")";
  const auto scene =
      folder_.write("two.json", R"({ "sensors": [ { "name": "left", )" + finger +
                                    R"(l.csv", "unit": "N" } }, { "name": "right", )" + finger +
                                    R"(r.csv", "unit": "N" } } ],
      "grasps": [ { "name": "hand", "sensors": ["left", "right"] } ],
      "objects": [ { "normal_n": [1, 20], "friction": [0.3, 1] } ] })");
  auto shorter = pillar_rows(0.2);
  shorter.resize(200);
  const auto left = "left=" + folder_.write("l.csv", csv_of(pillar_rows(0.3))).string();
  const auto right = "right=" + folder_.write("r.csv", csv_of(shorter)).string();
  const auto runs = replay(scene, "", {left, right});
  ASSERT_EQ(runs.size(), 3U);
  const ReplayRun& hand = runs[2];
  EXPECT_EQ(hand.sensor, "hand");
  ASSERT_EQ(hand.rows.size(), runs[0].rows.size());
  EXPECT_EQ(hand.rows[20].estimate.state, slipd::State::no_contact);
  ASSERT_TRUE(hand.rows[190].estimate.gamma);
  EXPECT_NEAR(hand.rows[190].estimate.normal_n.value(),
              runs[0].rows[190].estimate.normal_n.value() + runs[1].rows[190].estimate.normal_n.value(),
              1e-6);
  EXPECT_EQ(replay(scene, "left", {left}).size(), 1U) << "half a grasp has no rows";
}

TEST_F(Replay, RefusesWhatItCannotPlay) {
  EXPECT_THROW(replay(scene(), "thumb", {folder_.write("file.csv", csv_of(pillar_rows(0)))}),
               offline::WrongUse);
  EXPECT_ANY_THROW(run("txl1_x,txl1_y,txl1_z\n1,2,3\n")) << "one taxel of nine";
  EXPECT_ANY_THROW(run(csv_of(pillar_rows(0)), R"("unit": "N", "taxels": ["txl1"])"));
}

// A run of one row each 10 ms with alerts `slip` in some rows.
ReplayRun alerting(std::size_t rows, const std::vector<std::size_t>& alerts) {
  ReplayRun made{.sensor = "finger", .file = "file.csv", .rows = {}, .fault = {}};
  for (std::size_t i = 0; i < rows; ++i) {
    ReplayRow row{.time_s = 0.01 * static_cast<double>(i), .row = i, .estimate = {}};
    if (std::find(alerts.begin(), alerts.end(), i) != alerts.end()) row.estimate.alert = slipd::Alert::slip;
    made.rows.push_back(row);
  }
  return made;
}

std::vector<bool> slips_from(std::size_t rows, std::size_t first) {
  std::vector<bool> labels(rows);
  for (std::size_t i = first; i < rows; ++i) labels[i] = true;
  return labels;
}

TEST(ReplayLabels, GiveTheLeadOfTheFirstAlertThatBelongsToTheLabel) {
  const LabelScore early = score_alerts(alerting(300, {180, 181}), slips_from(300, 200));
  EXPECT_NEAR(early.lead_s.value(), 0.2, 1e-9);
  EXPECT_FALSE(early.missed);
  EXPECT_EQ(early.false_alerts, 0U);
  const LabelScore late = score_alerts(alerting(300, {210}), slips_from(300, 200));
  EXPECT_NEAR(late.lead_s.value(), -0.1, 1e-9);
  EXPECT_NEAR(late.unlabelled_s, 1.99, 1e-9);
}

TEST(ReplayLabels, CountWhatCameTooEarlyOrWithoutALabelAsFalse) {
  const LabelScore score = score_alerts(alerting(300, {20, 21, 100, 190}), slips_from(300, 200));
  EXPECT_EQ(score.false_alerts, 2U) << "an alert that stands is one";
  EXPECT_NEAR(score.lead_s.value(), 0.1, 1e-9);
  const LabelScore still = score_alerts(alerting(300, {20}), std::vector<bool>(300));
  EXPECT_EQ(still.false_alerts, 1U);
  EXPECT_FALSE(still.missed || still.lead_s);
}

TEST(ReplayLabels, WithoutAnAlertAreMissed) {
  const LabelScore score = score_alerts(alerting(300, {}), slips_from(300, 200));
  EXPECT_TRUE(score.missed);
  EXPECT_FALSE(score.lead_s);
  EXPECT_THAT(describe(score), HasSubstr("missed"));
}

TEST(ReplayLabels, AreReadFromTheColumnSlip) {
  const slipd::testing::TempFolder folder;
  const ReplayRun run = alerting(3, {});
  EXPECT_THAT(read_labels(folder.write("a.csv", "fail,slip\n0,0\n0,1\r\n1,1.0\n"), run),
              ElementsAre(false, true, true));
  EXPECT_THAT(read_labels(folder.write("b.csv", "slip\n1\n"), run), ElementsAre(true, true, true));
  EXPECT_THROW(read_labels(folder.write("c.csv", "slid\n1\n"), run), offline::WrongUse);
  EXPECT_THROW(read_labels(folder.write("d.csv", "slip\n1\n0\n"), run), offline::WrongUse)
      << "two rows for three";
  EXPECT_THROW(read_labels(folder.file("none.csv"), run), offline::WrongUse);
}

}  // namespace
}  // namespace sliplab
