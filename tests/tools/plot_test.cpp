// A recording drawn on the terminal, and the messages for one that is damaged or lacks data.
#include "tools/slipctl/plot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/estimate/estimate.hpp"
#include "tests/support/temp_folder.hpp"
#include "tests/tools/sample_recording.hpp"
#include "tools/slipctl/client.hpp"

namespace slipctl::testing {
namespace {

using slipd::read_recorded;
using slipd::testing::TempFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Plot : public ::testing::Test {
 protected:
  std::filesystem::path sample(bool estimates) const {
    write_sample_recording(folder_.file("s.rec"), estimates);
    return folder_.file("s.rec");
  }
  static std::string drawn(const slipd::Recorded& recorded) {
    return draw_recorded(recorded, "title", 80, 27, ColourDepth::rgb).to_text();
  }
  const TempFolder folder_;
};

TEST_F(Plot, ShowsMarginAlertsForcesAndTheTaxelsOfTheLeastMargin) {
  const auto recorded = read_recorded(sample(true), std::nullopt);
  EXPECT_EQ(recorded.frames.size(), kSampleFrames);
  EXPECT_EQ(recorded.shown, kSampleFrames - 1);
  EXPECT_NEAR(recorded.frames.back().normal_n, 1.6, 1e-5);
  EXPECT_NEAR(recorded.frames.back().shear_n, 0.8, 1e-5);
  EXPECT_THAT(
      drawn(recorded),
      AllOf(HasSubstr("margin"), HasSubstr("wwww"), HasSubstr("SSSS"), HasSubstr("≤ 1.60 N"),
            HasSubstr("≤ 0.80 N"), HasSubstr("1.99 s"), HasSubstr("at 1.990 s"), HasSubstr("ok, alert slip"),
            HasSubstr("margin   0.00 ±0.02"), HasSubstr("pressure ≤ 100.0 kPa"), HasSubstr("→")));
}

TEST_F(Plot, ShowsWhetherTheObjectSlidAndWhatAnAlertCameFrom) {
  EXPECT_THAT(drawn(read_recorded(sample(true), std::nullopt)),
              AllOf(HasSubstr("slides"), HasSubstr("───"), HasSubstr("ddd"), HasSubstr("ttt"),
                    HasSubstr("slides   translation")));
  PlotOptions options;
  options.file = sample(true);
  options.json = true;
  ::testing::internal::CaptureStdout();
  plot(options);
  const std::string lines = ::testing::internal::GetCapturedStdout();
  EXPECT_THAT(lines, AllOf(HasSubstr(R"("sliding":"none","alert_cause":null)"),
                           HasSubstr(R"("sliding":"disturbed","alert_cause":"margin")"),
                           HasSubstr(R"("sliding":"translation","alert_cause":"sliding")")));
}

TEST_F(Plot, ShowsNoSlipWhereTheAlertWasUnknown) {
  auto recorded = read_recorded(sample(true), std::nullopt);
  for (auto& frame : recorded.frames)
    frame.estimate->alert = static_cast<std::uint8_t>(slipd::Alert::unknown);
  EXPECT_THAT(drawn(recorded), AllOf(HasSubstr("alert unknown"), Not(HasSubstr("SS"))));
}

TEST_F(Plot, ShowsTheTaxelsOfTheMomentAskedFor) {
  EXPECT_THAT(drawn(read_recorded(sample(true), 1.0)),
              AllOf(HasSubstr("at 1.000 s"), HasSubstr("ok, alert none"), HasSubstr("margin   0.50 ±0.02")));
}

TEST_F(Plot, OfFramesAloneShowsTheForcesAndWhatASimulationKnows) {
  EXPECT_THAT(drawn(read_recorded(sample(false), std::nullopt)),
              AllOf(HasSubstr("truth"), HasSubstr("≤ 1.60 N"), Not(HasSubstr("SSSS")), Not(HasSubstr("±"))));
}

TEST_F(Plot, FitsIntoAnyWindow) {
  const auto recorded = read_recorded(sample(true), std::nullopt);
  for (const int columns : {40, 80, 333})
    for (const int rows : {16, 26, 60})
      EXPECT_EQ(draw_recorded(recorded, "title", columns, rows, ColourDepth::none).columns(), columns);
}

TEST_F(Plot, OfACutFileShowsWhatThereIs) {
  const auto file = sample(true);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) * 9 / 10);
  const auto recorded = read_recorded(file, std::nullopt);
  EXPECT_GT(recorded.frames.size(), 0U);
  EXPECT_LT(recorded.frames.size(), kSampleFrames) << "the last block is cut";
  EXPECT_THAT(recorded.fault, HasSubstr("ends within"));
}

TEST_F(Plot, OfSomethingElseIsRefused) {
  PlotOptions options;
  options.file = folder_.write("x.rec", "no recording");
  EXPECT_THROW(plot(options), ClientError);
  options.file = folder_.file("none.rec");
  EXPECT_THROW(plot(options), ClientError);
}

}  // namespace
}  // namespace slipctl::testing
