// Messages of ROS 2 → values of taxels, by profiles.
#include "bridges/feed_ros2/topic_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <vector>

#include "bridges/ros2/messages/cdr.hpp"
#include "schema/settings_error.hpp"

namespace slipd::feed_ros2 {
namespace {

using feed::Outcome;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::int64_t kSentNs = 1'500'000'000;

TopicProfile profile(const std::string& keys, std::size_t taxels = 2, const std::string& frame_id = "") {
  return parse_topic_profile(
      R"({"description": "x", "tested": "synthetic", "source": "x", "topic": "/t", "unit": "N", )" + keys +
          "}",
      "test.json", {"", frame_id, taxels});
}

const std::string kRows =
    R"("type": "std_msgs/Float32MultiArray", "columns": [0, 1, 2], "array": {"row": 3})";
const std::string kCloud = R"("type": "sensor_msgs/PointCloud2", "fields": ["x", "y", "z"])";
const std::string kWrench = R"("type": "geometry_msgs/WrenchStamped")";

// A reader, and what it has read last.
struct Read {
  explicit Read(TopicProfile of) : reader(std::move(of)) {}
  template <class T>
  Outcome operator()(const T& message) {
    std::vector<std::uint8_t> bytes;
    ros2::encode(message, bytes);
    return reader.read({{}, bytes, kSentNs}, reading);
  }
  TopicReader reader;
  feed::Reading reading;
};

ros2::Float32MultiArray array(std::vector<float> data) {
  ros2::Float32MultiArray message;
  message.data = std::move(data);
  return message;
}

// Two points of x, y and z.
ros2::PointCloud2 cloud(const std::vector<float>& numbers = {1, 2, 3, 4, 5, 6}) {
  ros2::PointCloud2 message;
  message.header.stamp = {.sec = 3, .nanosec = 250'000'000};
  message.height = 1;
  message.width = 2;
  for (const char* name : {"x", "y", "z"})
    message.point_fields.push_back(
        {.name = name, .offset = static_cast<std::uint32_t>(4 * message.point_fields.size())});
  message.point_step = 12;
  message.row_step = 24;
  message.data.resize(4 * numbers.size());
  std::memcpy(message.data.data(), numbers.data(), message.data.size());
  return message;
}

TEST(Arrays, HaveTheNumbersOfOneTaxelSideBySide) {
  Read read(profile(kRows));
  ASSERT_EQ(read(array({1, 2, 3, 4, 5, 6})), Outcome::frame);
  EXPECT_THAT(read.reading.values, ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST(Arrays, OrOneAxisAfterTheOther) {
  Read read(profile(
      R"("type": "std_msgs/Float32MultiArray", "columns": [2, 0, 1], "array": {"row": 4, "order": "axes", "first": 1})"));
  ASSERT_EQ(read(array({9, 1, 2, 3, 4, 5, 6, 7, 8})), Outcome::frame);
  EXPECT_THAT(read.reading.values, ElementsAre(5, 1, 3, 6, 2, 4));
}

TEST(Arrays, AreOfTheTimeAtWhichTheyWereSent) {
  Read read(profile(kRows));
  read(array({1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(read.reading.sent_s, 1.5);
  EXPECT_EQ(read.reading.sequence, std::uint64_t{kSentNs});
  EXPECT_FALSE(read.reading.counted);
}

TEST(Arrays, OfAnotherLengthAreCorruptWithBothLengthsInTheReason) {
  Read read(profile(kRows));
  EXPECT_EQ(read(array({1, 2, 3, 4, 5})), Outcome::corrupt);
  EXPECT_THAT(read.reader.why(), HasSubstr("5 numbers; expected 6"));
  EXPECT_EQ(read(array({1, 2, 3, 4, 5, 6, 7})), Outcome::corrupt);
}

TEST(Messages, WithAValueThatIsNotFiniteAsAFloatAreCorrupt) {
  Read arrays(profile(kRows)), wrenches(profile(kWrench, 0));
  EXPECT_EQ(arrays(array({1, 2, 3, 4, 5, std::numeric_limits<float>::quiet_NaN()})), Outcome::corrupt);
  ros2::WrenchStamped wrench;
  wrench.header.stamp.sec = 1;
  wrench.wrench.force = {1, 2, 1e300};
  EXPECT_EQ(wrenches(wrench), Outcome::corrupt);
  EXPECT_THAT(wrenches.reader.why(), HasSubstr("not finite"));
}

TEST(Wrenches, AreOneTaxel) {
  Read read(profile(kWrench, 0));
  ros2::WrenchStamped wrench;
  wrench.header.stamp = {.sec = 2, .nanosec = 500'000'000};
  wrench.wrench.force = {1, -2, 3};  // the torque stays unknown
  ASSERT_EQ(read(wrench), Outcome::frame);
  EXPECT_THAT(read.reading.values, ElementsAre(1, -2, 3));
  EXPECT_EQ(read.reading.sent_s, 2.5);
}

TEST(Clouds, AreReadByTheNamesOfTheirFields) {
  Read all(profile(kCloud)), normal(profile(R"("type": "sensor_msgs/PointCloud2", "fields": ["y"])"));
  ASSERT_EQ(all(cloud()), Outcome::frame);
  EXPECT_THAT(all.reading.values, ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_EQ(all.reading.sent_s, 3.25);
  ASSERT_EQ(normal(cloud()), Outcome::frame);
  EXPECT_THAT(normal.reading.values, ElementsAre(2, 5));
}

TEST(Clouds, WhoseSizesContradictEachOtherAreCorrupt) {
  Read read(profile(kCloud));
  const auto is_corrupt = [&](const auto& change) {
    ros2::PointCloud2 message = cloud();
    change(message);
    EXPECT_EQ(read(message), Outcome::corrupt);
    EXPECT_FALSE(read.reader.why().empty());
  };
  is_corrupt([](auto& m) { m.width = 3; });
  is_corrupt([](auto& m) { m.height = 0; });
  is_corrupt([](auto& m) { m.height = m.width = 0xFFFFFFFF; });
  is_corrupt([](auto& m) { m.row_step = 23; });
  is_corrupt([](auto& m) { m.point_step = 0xFFFFFFFF; });
  is_corrupt([](auto& m) { m.data.pop_back(); });
  is_corrupt([](auto& m) { m.point_fields[2].offset = 9; });
  is_corrupt([](auto& m) { m.point_fields[2].offset = 0xFFFFFFFF; });
  is_corrupt([](auto& m) { m.point_fields[2].count = 2; });
  is_corrupt([](auto& m) { m.point_fields[2].datatype = 0; });
  is_corrupt([](auto& m) { m.point_fields.pop_back(); });
}

TEST(Stamps, ThatAreNoTimeAreToldWithTheRemedy) {
  Read read(profile(kCloud));
  for (const ros2::Time stamp : {ros2::Time{0, 0}, ros2::Time{-1, 0}, ros2::Time{1, 1'000'000'000}}) {
    ros2::PointCloud2 message = cloud();
    message.header.stamp = stamp;
    EXPECT_EQ(read(message), Outcome::corrupt);
    EXPECT_THAT(read.reader.why(), HasSubstr(R"("time": "sent")"));
  }
  Read sent(profile(kCloud + R"(, "time": "sent")"));
  ros2::PointCloud2 message = cloud();
  message.header.stamp = {};
  EXPECT_EQ(sent(message), Outcome::frame);
}

TEST(Stamps, DoNotCountWhereTheProfileTakesTheArrival) {
  Read read(profile(kRows + R"(, "time": "received")"));
  ASSERT_EQ(read(array({1, 2, 3, 4, 5, 6})), Outcome::frame);
  EXPECT_FALSE(read.reading.sent_s || read.reading.sequence);
}

TEST(Frames, OfAnotherFrameIdAreOfAnotherSensor) {
  Read read(profile(kCloud, 2, "left"));
  EXPECT_EQ(read(cloud()), Outcome::other);
  ros2::PointCloud2 ours = cloud();
  ours.header.frame_id = "left";
  EXPECT_EQ(read(ours), Outcome::frame);
}

TEST(Profiles, ThatContradictThemselvesAreRefused) {
  for (const std::string keys :
       {R"("type": "std_msgs/Float32MultiArray", "array": {"row": 3})",
        R"("type": "std_msgs/Float32MultiArray", "columns": [0, 1, 3], "array": {"row": 3})",
        R"("type": "std_msgs/Float32MultiArray", "columns": [0, 1], "array": {"row": 3})",
        R"("type": "std_msgs/Float32MultiArray", "columns": [0], "array": {"row": 1}, "time": "stamp")",
        R"("type": "sensor_msgs/PointCloud2", "columns": [0])",
        R"("type": "geometry_msgs/WrenchStamped", "fields": ["x"])"})
    EXPECT_THROW(profile(keys), SettingsError) << keys;
  EXPECT_THROW(profile(kWrench, 2), SettingsError);
  EXPECT_THROW(profile(kCloud, 0), SettingsError) << "no number of taxels";
  EXPECT_THROW(profile(kRows, 2, "left"), SettingsError) << "arrays have no frame_id";
}

}  // namespace
}  // namespace slipd::feed_ros2
