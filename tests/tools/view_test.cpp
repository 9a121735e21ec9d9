#include "tools/slipctl/view.hpp"

#include <gmock/gmock.h>

#include "tests/tools/samples.hpp"

namespace slipctl::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr ColourDepth kDepths[] = {ColourDepth::none, ColourDepth::basic16, ColourDepth::indexed256,
                                   ColourDepth::rgb};

std::string screen(const WatchState& state, int columns = 80, int rows = 24) {
  return draw_watch(state, columns, rows, ColourDepth::rgb).to_text();
}

TEST(View, HasTheTerminalsSizeWhateverThatIs) {
  for (const int sensors : {0, 1, 2, 5, 40}) {
    const WatchState state = watch_sample(sensors);
    for (const int columns : {1, 20, 80, 211})
      for (const int rows : {1, 5, 24, 60})
        for (const ColourDepth depth : kDepths) {
          const Canvas canvas = draw_watch(state, columns, rows, depth);
          EXPECT_EQ(canvas.columns(), columns);
          EXPECT_EQ(canvas.rows(), rows);
        }
  }
}

TEST(View, ShowsEverythingOfOneSensorAt80By24) {
  EXPECT_THAT(screen(watch_sample(1)),
              AllOf(HasSubstr("s0"), HasSubstr("simulated"), HasSubstr("sim · 10000 taxels · moments"),
                    HasSubstr("1000 Hz  35.2 µs"), HasSubstr("ok"), HasSubstr("±0.01"), HasSubstr("true 0."),
                    HasSubstr("class"), HasSubstr("pressure ≤ 49.9 kPa"), HasSubstr("→ → →")));
  EXPECT_THAT(
      screen(watch_sample(1)),
      AllOf(HasSubstr("normal    2.10 N"), HasSubstr("shear     0.36 N"), HasSubstr("friction  0.45 ±0.02"),
            HasSubstr(" true     0.44"), HasSubstr("centre    0.1, -0.4 mm"), HasSubstr("radius    3.10 mm"),
            HasSubstr("slips in  –"), HasSubstr("grip by   +0.50 N"), HasSubstr("skipped   3")));
}

TEST(View, HasAMapForEachOfTwoFingersAt80By24) {
  const std::string text = screen(watch_sample(2));
  EXPECT_NE(text.find("pressure ≤"), text.rfind("pressure ≤"));
  EXPECT_THAT(text, AllOf(HasSubstr("s0"), HasSubstr("s1")));
}

TEST(View, NamesEverySensorThatHasRoomAndCountsTheOthers) {
  EXPECT_THAT(screen(watch_sample(11)), AllOf(HasSubstr("s0 "), HasSubstr("s10 "), Not(HasSubstr("more"))));
  EXPECT_THAT(screen(watch_sample(31)),
              AllOf(HasSubstr("s10 "), Not(HasSubstr("s11 ")), HasSubstr("and 20 more")));
}

TEST(View, ShowsEveryStateAndNoMarginOutsideOk) {
  for (const char* state :
       {"no_contact", "learning", "out_of_model", "no_shear", "unzeroed", "stale", "fault"}) {
    const std::string text = screen(watch_sample(1, state));
    EXPECT_THAT(text,
                AllOf(HasSubstr(state), HasSubstr("class –"), Not(HasSubstr("█")), Not(HasSubstr("±0.01"))));
  }
}

TEST(View, ShowsWhetherTheObjectSlidesAndAnAlertThatComesFromIt) {
  WatchState state = watch_sample(1, "out_of_model");
  EXPECT_THAT(screen(state), HasSubstr("slides    none 2.5 s"));
  state.sensors[0].latest->sliding = "rotation";
  state.sensors[0].latest->sliding_for_ms = 340;
  state.sensors[0].latest->alert = "slip";
  state.sensors[0].latest->alert_cause = "sliding";
  EXPECT_THAT(screen(state), AllOf(HasSubstr("slides    rotation 0.3 s"), HasSubstr(" slip: slides")));
  EXPECT_THAT(plain_line(state.sensors[0], 1), HasSubstr("slides rotation 0.3 s  alert slip: slides"));
  state.sensors[0].latest->sliding.clear();
  EXPECT_THAT(screen(state), HasSubstr("slides    –"));
}

TEST(View, FillsTheBarInProportionToTheMargin) {
  const auto filled = [](double gamma) {
    WatchState state = watch_sample(1);
    state.sensors[0].latest->gamma = gamma;
    state.sensors[0].latest->true_gamma.reset();
    const Canvas canvas = draw_watch(state, 80, 24, ColourDepth::rgb);
    int count = 0;
    for (int column = 0; column < 80; ++column) count += canvas.at(column, 2).glyph == U'█' ? 1 : 0;
    return count;
  };
  EXPECT_EQ(filled(0), 0);
  EXPECT_EQ(filled(1), 2 * filled(0.5) + filled(1) % 2);
  EXPECT_GT(filled(1), 25);
}

TEST(View, ShowsGraspsBelowTheirSensors) {
  WatchState state = watch_sample(2);
  EstimateValues grasp = *state.sensors[0].latest;
  grasp.name = "gripper";
  grasp.gamma = 0.31;
  grasp.alert = "warn";
  state.grasps = {grasp};
  const Canvas canvas = draw_watch(state, 80, 24, ColourDepth::rgb);
  EXPECT_THAT(canvas.row_text(23),
              AllOf(HasSubstr("gripper"), HasSubstr("███"), HasSubstr("0.31"), HasSubstr("warn")));
  state.grasps[0].gamma.reset();
  state.grasps[0].state = "learning";
  EXPECT_THAT(screen(state), HasSubstr("learning"));
}

TEST(View, ShowsWhatSlipdGripDoesInTheLastRow) {
  WatchState state = watch_sample(2);
  state.grasps = {*state.sensors[0].latest};
  state.grip =
      GripWatch{.state = "tightening", .why = "margin low", .force_n = 8.25, .width_mm = 41, .trouble = ""};
  const Canvas canvas = draw_watch(state, 80, 24, ColourDepth::rgb);
  EXPECT_THAT(canvas.row_text(23),
              AllOf(HasSubstr("slipd-grip"), HasSubstr("tightening"), HasSubstr("8.2 N a finger"),
                    HasSubstr("41.0 mm wide"), HasSubstr("(margin low)")));
  state.grip->trouble = "does not answer";
  EXPECT_THAT(screen(state), HasSubstr("does not answer"));
}

TEST(View, MarksTheSimulatedOnesOnly) {
  WatchState state = watch_sample(1);
  state.sensors[0].info.simulated = false;
  state.sensors[0].latest->true_gamma.reset();
  state.sensors[0].latest->true_friction.reset();
  EXPECT_THAT(screen(state), AllOf(Not(HasSubstr("simulated")), Not(HasSubstr("true"))));
}

TEST(View, ShowsAnAlertInItsColour) {
  WatchState state = watch_sample(1);
  state.sensors[0].latest->alert = "slip";
  const Canvas canvas = draw_watch(state, 80, 24, ColourDepth::rgb);
  EXPECT_THAT(canvas.row_text(1), HasSubstr(" slip"));
  EXPECT_TRUE(canvas.at(77, 1).style.background);
}

TEST(View, DrawsTheCourseHighForASafeGripAndLowForASlip) {
  for (const auto& [gamma, row] : {std::pair{1.0, 3}, std::pair{0.0, 6}}) {
    WatchState state = watch_sample(1);
    for (MarginPoint& point : state.sensors[0].history) point.gamma = gamma;
    const Canvas canvas = draw_watch(state, 80, 24, ColourDepth::rgb);
    EXPECT_GE(canvas.at(40, row).glyph, U'⠁');
    EXPECT_LE(canvas.at(40, row).glyph, U'⣿');
  }
}

TEST(View, HasATimeAxisUnderTheCourse) {
  const Canvas canvas = draw_watch(watch_sample(1), 80, 24, ColourDepth::rgb);
  EXPECT_THAT(canvas.row_text(7), AllOf(HasSubstr("-10 s"), HasSubstr("-5 s"), HasSubstr("now")));
}

TEST(View, DrawsASteepCourseAsALineWithoutHoles) {
  WatchState state = watch_sample(1);
  for (MarginPoint& point : state.sensors[0].history) point.gamma = point.time_s < 5 ? 1.0 : 0.0;
  const Canvas canvas = draw_watch(state, 80, 24, ColourDepth::rgb);
  const auto drawn = [&](int row) {
    for (int column = 2; column < 80; ++column)
      if (canvas.at(column, row).glyph != U' ') return true;
    return false;
  };
  for (const int row : {3, 4, 5, 6}) EXPECT_TRUE(drawn(row)) << "row " << row;
}

TEST(View, DrawsBeforeAnythingHasCome) {
  WatchState state = watch_sample(1);
  state.sensors[0] = SensorWatch{state.sensors[0].info, {}, {}, {}, 0, {}};
  EXPECT_THAT(screen(state), AllOf(HasSubstr("stale"), HasSubstr("– Hz")));
}

TEST(View, UsesNoColourForAnythingThatHasToBeRead) {
  const Canvas canvas = draw_watch(watch_sample(2), 80, 24, ColourDepth::none);
  for (int row = 0; row < canvas.rows(); ++row)
    EXPECT_THAT(encode_row(canvas, row, ColourDepth::none), Not(HasSubstr("\x1b")));
}

TEST(PlainLine, SaysItAllInOneLine) {
  const WatchState state = watch_sample(1);
  EXPECT_THAT(plain_line(state.sensors[0], 1.25),
              AllOf(HasSubstr("1.25 s  s0  ok  margin 0."), HasSubstr("true 0."), HasSubstr("class"),
                    HasSubstr("alert"), HasSubstr("simulated"), Not(HasSubstr("\n"))));
}

}  // namespace
}  // namespace slipctl::testing
