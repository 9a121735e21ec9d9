// A recording exported as CSV and as MCAP. tests/bridges/ros2/peers compares MCAP files with recordings
// sample by sample.
#include "tools/slipctl/export.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temp_folder.hpp"
#include "tests/tools/sample_recording.hpp"
#include "tools/slipctl/client.hpp"

namespace slipctl::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class Export : public ::testing::Test {
 protected:
  ExportOptions options(bool estimates, bool whole = true) const {
    write_sample_recording(folder_.file("s.rec"), estimates, whole);
    ExportOptions options;
    options.file = folder_.file("s.rec");
    options.prefix = "/slipd";
    return options;
  }
  static std::vector<std::string> lines_of(const std::string& file) {
    std::vector<std::string> lines;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
  }
  static std::string why(const ExportOptions& options) {
    try {
      export_recording(options);
    } catch (const ClientError& error) {
      return error.what();
    }
    return "it was exported";
  }
  const slipd::testing::TempFolder folder_;
};

TEST_F(Export, CsvHasALineForEachFrameAndEmptyFieldsForWhatIsUnknown) {
  ExportOptions csv = options(true);
  csv.csv = folder_.file("s.csv");
  EXPECT_TRUE(export_recording(csv));
  const auto lines = lines_of(csv.csv);
  ASSERT_EQ(lines.size(), 1 + kSampleFrames);
  EXPECT_THAT(lines[0], StartsWith("time,realtime_ns,seq,state,alert,gamma,sigma,friction,"));
  EXPECT_THAT(lines[0], HasSubstr(",txl1_x,txl1_y,txl1_z,txl2_x,"));
  EXPECT_THAT(lines[1], StartsWith("0,"));
  EXPECT_THAT(lines[1], HasSubstr(",1000,ok,none,1,0.02,0.5,1.6,0,none,none,0,,0.9,,0,0,,,0.001,-0.002,,,,,,,"
                                  "moments,good,1,0.5,0,0,1e+05,"));
  for (const std::string& line : lines)
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), std::count(lines[0].begin(), lines[0].end(), ','));
}

TEST_F(Export, CsvOfARecordingWithoutEstimatesHasItsFrames) {
  ExportOptions csv = options(false);
  csv.csv = folder_.file("s.csv");
  EXPECT_TRUE(export_recording(csv));
  EXPECT_THAT(lines_of(csv.csv).at(1),
              HasSubstr(",1000" + std::string(slipd::kRecordedEntries.size(), ',') + ",1,0.5,0,0,1e+05,"));
}

TEST_F(Export, OfAnOlderRecordingLeavesOutWhatItDoesNotHaveAndSaysSo) {
  for (const bool whole : {true, false}) {
    ExportOptions csv = options(true, whole);
    csv.csv = folder_.file("s.csv");
    csv.mcap = folder_.file("s.mcap");
    csv.force = true;
    ::testing::internal::CaptureStderr();
    EXPECT_TRUE(export_recording(csv));
    const std::string said = ::testing::internal::GetCapturedStderr();
    EXPECT_EQ(said.find("older slipd") != std::string::npos, !whole) << said;
    EXPECT_EQ(lines_of(csv.csv)[1].find(",moments,good,") != std::string::npos, whole);
  }
}

TEST_F(Export, BothAreWrittenAtOnceAndNoneIsReplacedUnlessForced) {
  ExportOptions both = options(true);
  both.csv = folder_.file("s.csv");
  both.mcap = folder_.file("s.mcap");
  EXPECT_TRUE(export_recording(both));
  EXPECT_GT(std::filesystem::file_size(both.mcap), 1000U);
  EXPECT_THAT(why(both), HasSubstr("exists already"));
  both.mcap.clear();
  EXPECT_THAT(why(both), HasSubstr("exists already"));
  both.force = true;
  EXPECT_EQ(why(both), "it was exported");
}

TEST_F(Export, SaysWhatIsNoRecordingAndWhatCannotBeWritten) {
  ExportOptions wrong = options(true);
  wrong.csv = folder_.file("no/such/folder.csv");
  EXPECT_THAT(why(wrong), HasSubstr("cannot write"));
  wrong.csv = folder_.file("s.csv");
  wrong.file = folder_.write("text", "no recording");
  EXPECT_THAT(why(wrong), HasSubstr("byte 0"));
}

}  // namespace
}  // namespace slipctl::testing
