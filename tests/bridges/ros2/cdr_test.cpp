// The encoder, against bytes written out by the rules of XCDR version 1.
#include "bridges/ros2/messages/cdr.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bridges/ros2/messages/sensor_messages.hpp"

namespace slipd::ros2 {
namespace {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;

template <class T>
std::vector<std::uint8_t> encoded(const T& message) {
  std::vector<std::uint8_t> bytes{1, 2, 3};  // what was there before does not matter
  encode(message, bytes);
  return bytes;
}

TEST(Cdr, NumbersAreLittleEndianBehindTheHeader) {
  EXPECT_THAT(encoded(Float32{.data = 0.5F}), ElementsAre(0, 1, 0, 0, 0, 0, 0, 0x3F));
}

TEST(Cdr, TextsHaveTheirLengthWithTheZeroAndDoublesAlignToEight) {
  WrenchStamped message;
  message.header.stamp = {.sec = 1, .nanosec = 2};
  message.header.frame_id = "ab";
  message.wrench.force = {1, 0, 0};
  const auto bytes = encoded(message);
  const std::vector<std::uint8_t> begin{0, 1, 0,   0,   1, 0, 0, 0, 2, 0, 0, 0, 3,    0,
                                        0, 0, 'a', 'b', 0, 0, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F};
  ASSERT_EQ(bytes.size(), 4U + 16U + 6U * 8U);
  EXPECT_THAT(std::vector(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(begin.size())),
              ElementsAreArray(begin));
}

TEST(Cdr, SequencesOfMessagesAlignEachElement) {
  DiagnosticArray message;
  message.header.frame_id = "";
  message.status.resize(1);
  message.status[0].level.value = 2;
  message.status[0].name = "n";
  message.status[0].values = {{.key = "k", .value = "v"}};
  EXPECT_THAT(
      encoded(message),
      ElementsAre(0, 1, 0, 0,                                      // header
                  0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0,  // stamp, "", padding
                  1, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 'n', 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0,  // 1, 2, "n", ""
                  1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0,                                        // "", 1
                  2, 0, 0, 0, 'k', 0, 0, 0, 2, 0, 0, 0, 'v', 0));
}

PointCloud2 sample_cloud() {
  PointCloud2 cloud;
  cloud.header = {.stamp = {.sec = 5, .nanosec = 6}, .frame_id = "left"};
  cloud.height = 1;
  cloud.width = 2;
  cloud.point_fields = {{.name = "x", .offset = 0, .datatype = 7, .count = 1},
                        {.name = "normal", .offset = 4, .datatype = 8, .count = 1}};
  cloud.point_step = 12;
  cloud.row_step = 24;
  cloud.data.resize(24, 7);
  return cloud;
}

// The bytes of a message that was decoded and encoded again.
template <class T>
std::vector<std::uint8_t> again(const std::vector<std::uint8_t>& bytes) {
  T message;
  EXPECT_TRUE(decode(bytes, message));
  return encoded(message);
}

TEST(Cdr, WhatIsDecodedIsWhatWasEncoded) {
  Float32MultiArray array;
  array.layout = {.dim = {{.label = "taxel", .size = 3, .stride = 3}}, .data_offset = 0};
  array.data = {1, -2, 0.5F};
  WrenchStamped wrench;
  wrench.header.frame_id = "wrist";
  wrench.wrench.force = {1, 2, 3};
  EXPECT_EQ(again<Float32MultiArray>(encoded(array)), encoded(array));
  EXPECT_EQ(again<WrenchStamped>(encoded(wrench)), encoded(wrench));
  EXPECT_EQ(again<PointCloud2>(encoded(sample_cloud())), encoded(sample_cloud()));
}

TEST(Cdr, BigEndianBytesAreReadAsTheyAreMeant) {
  const std::vector<std::uint8_t> bytes{0, 0, 0, 0,                 // header
                                        0, 0, 0, 0, 0,    0, 0, 1,  // no dimensions, data_offset 1
                                        0, 0, 0, 2, 0x3F, 0, 0, 0, 0xC0, 0, 0, 0};
  Float32MultiArray array;
  ASSERT_TRUE(decode(bytes, array));
  EXPECT_EQ(array.layout.data_offset, 1U);
  EXPECT_THAT(array.data, ElementsAre(0.5F, -2.0F));
}

TEST(Cdr, AMessageThatIsCutOffAnywhereIsNone) {
  const auto bytes = encoded(sample_cloud());
  PointCloud2 cloud;
  for (std::size_t length = 0; length < bytes.size(); ++length)
    EXPECT_FALSE(decode(std::span(bytes).first(length), cloud)) << length;
}

TEST(Cdr, ALengthBeyondTheEndIsNoMessageAndTakesNoMemory) {
  std::vector<std::uint8_t> bytes{0, 1, 0,    0,    0,    0,    0, 0, 0,    0,
                                  0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 0, 0, 0x80, 0x3F};
  Float32MultiArray array;
  EXPECT_FALSE(decode(bytes, array));
  EXPECT_LE(array.data.capacity(), 4U);
}

TEST(Cdr, AnotherEncodingOrATextWithoutItsZeroIsNone) {
  auto bytes = encoded(sample_cloud());
  PointCloud2 cloud;
  bytes[1] = 7;  // XCDR version 2
  EXPECT_FALSE(decode(bytes, cloud));
  bytes[1] = 1;
  bytes[20] = 'x';  // behind "left"
  EXPECT_FALSE(decode(bytes, cloud));
}

TEST(Estimates, AreUnknownUntilSlipdSaysSomething) {
  const SlipEstimate none;
  EXPECT_EQ(none.alert, SlipEstimate::kAlertUnknown);
  EXPECT_EQ(none.state, SlipEstimate::kStale);
  EXPECT_EQ(none.sliding, SlipEstimate::kSlidingUnknown);
  EXPECT_TRUE(std::isnan(none.margin) && std::isnan(none.margin_low));
}

TEST(Margins, AreNumbersInStateOkOnly) {
  SlipEstimate estimate;
  estimate.margin = 0.5;
  estimate.margin_low = 0.4;
  for (int state = 0; state <= SlipEstimate::kDisconnected; ++state) {
    estimate.state = static_cast<std::uint8_t>(state);
    EXPECT_EQ(std::isnan(margin_of(estimate).data), state != SlipEstimate::kOk) << state;
    EXPECT_EQ(std::isnan(margin_low_of(estimate).data), state >= SlipEstimate::kUnzeroed) << state;
    EXPECT_EQ(std::isnan(wrench_of(estimate).wrench.force.x), true) << "no shear is known";
  }
}

// An estimate of point forces has the wrench of the taxels that it was made of.
TEST(Wrenches, OfAnEstimateAndOfItsTaxelsAreTheSame) {
  const std::array<double, 2> x{0.001, 0.003};
  const std::array<double, 2> y{0.002, 0.002};
  const std::array<float, 2> normal{1000, 3000};
  const std::array<float, 2> shear_x{100, -200};
  const std::array<float, 2> shear_y{50, 300};
  const double area = 1e-6;
  const Wrench sum = wrench_of(Taxels{x, y, normal, shear_x, shear_y}, area, true);
  SlipEstimate estimate;
  estimate.state = SlipEstimate::kOk;
  estimate.normal_force = 4000e-6;
  estimate.shear_force_x = -100e-6;
  estimate.shear_force_y = 350e-6;
  estimate.center_x = (0.001 * 1000 + 0.003 * 3000) / 4000;
  estimate.center_y = 0.002;
  estimate.torque = ((0.001 - estimate.center_x) * 50 + (0.003 - estimate.center_x) * 300) * area;
  const Wrench made = wrench_of(estimate).wrench;
  constexpr double kRounding = 1e-15;  // of sums of two products
  EXPECT_NEAR(sum.force.x, made.force.x, kRounding);
  EXPECT_NEAR(sum.force.y, made.force.y, kRounding);
  EXPECT_NEAR(sum.force.z, made.force.z, kRounding);
  EXPECT_NEAR(sum.torque.x, made.torque.x, kRounding);
  EXPECT_NEAR(sum.torque.y, made.torque.y, kRounding);
  EXPECT_NEAR(sum.torque.z, made.torque.z, kRounding);
  EXPECT_NEAR(sum.force.z, -4000e-6, kRounding) << "pressed: against z, which points out of the skin";
}

TEST(Wrenches, WithoutShearHaveNoTangentialPart) {
  const std::array<double, 2> at{0, 0.001};
  const std::array<float, 2> pressure{1, 2};
  const std::array<float, 2> none{0, 0};
  const Wrench wrench = wrench_of(Taxels{at, at, pressure, none, none}, 1, false);
  EXPECT_TRUE(std::isnan(wrench.force.x) && std::isnan(wrench.force.y) && std::isnan(wrench.torque.z));
  EXPECT_EQ(wrench.force.z, -3);
}

TEST(Clouds, HaveAPointForEachTaxel) {
  const std::array<double, 1> x{0.5};
  const std::array<double, 1> y{0.25};
  const std::array<float, 1> normal{1};
  const std::array<float, 1> shear_x{2};
  const std::array<float, 1> shear_y{3};
  PointCloud2 cloud;
  for (int twice = 0; twice < 2; ++twice) fill_cloud(Header(), Taxels{x, y, normal, shear_x, shear_y}, cloud);
  EXPECT_EQ(cloud.point_fields.size(), 6U);
  ASSERT_EQ(cloud.data.size(), cloud.point_step);
  std::array<float, 6> point{};
  std::memcpy(point.data(), cloud.data.data(), sizeof point);
  EXPECT_THAT(point, ElementsAre(0.5F, 0.25F, 0.0F, 1.0F, 2.0F, 3.0F));
}

TEST(Topics, HaveNamesThatRosAllows) {
  EXPECT_EQ(topic_of("/slipd", "left", "margin"), "/slipd/left/margin");
  EXPECT_EQ(topic_of("/slipd", "2nd finger.a-b", "margin"), "/slipd/_2nd_finger_a_b/margin");
}

TEST(Times, AreSecondsAndTheRest) {
  EXPECT_EQ(time_of(1'700'000'000'000'000'005).sec, 1'700'000'000);
  EXPECT_EQ(time_of(1'700'000'000'000'000'005).nanosec, 5U);
  EXPECT_EQ(time_of(-1).sec, -1);
  EXPECT_EQ(time_of(-1).nanosec, 999'999'999U);
}

}  // namespace
}  // namespace slipd::ros2
