// The descriptors and answers of a simulated USB device, without a bus.
#include "tests/devices/usb_requests.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slipd::devices {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;

class Requests : public ::testing::TestWithParam<const DeviceModel*> {
 protected:
  std::optional<Bytes> descriptor(std::uint8_t type, std::uint8_t index) {
    return control({0x80, 6, index, type, 0, 0, 255, 0});
  }
  std::optional<Bytes> control(const Bytes& setup) { return requests_.control(setup); }

  HostState host_state_;
  UsbRequests requests_{*GetParam(), host_state_, "S1"};
};
INSTANTIATE_TEST_SUITE_P(Devices, Requests, ::testing::Values(&takktile(), &papillarray(), &robotiq_tsf85()),
                         [](const auto& tested) {
                           std::string name(tested.param->name);
                           std::erase(name, '-');
                           return name;
                         });

TEST_P(Requests, DescribeTheDevice) {
  const Bytes device = *descriptor(1, 0);
  ASSERT_THAT(device, SizeIs(18));
  EXPECT_EQ(device[8] | device[9] << 8, GetParam()->usb->vendor);
  EXPECT_EQ(device[10] | device[11] << 8, GetParam()->usb->product);
  EXPECT_EQ(*descriptor(3, 3), (Bytes{6, 3, 'S', 0, '1', 0}));
  EXPECT_FALSE(descriptor(6, 0)) << "a full-speed device has no qualifier";
}

TEST_P(Requests, DescribeAConfigurationWhosePartsAddUp) {
  const Bytes configuration = *descriptor(2, 0);
  EXPECT_EQ(configuration[2] | configuration[3] << 8, configuration.size());
  std::size_t at = 0, interfaces = 0;
  bool has_in_endpoint = false;
  for (; at < configuration.size(); at += configuration[at]) {
    ASSERT_GE(configuration[at], 2);
    interfaces += configuration[at + 1] == 4 ? 1 : 0;
    has_in_endpoint |= configuration[at + 1] == 5 && configuration[at + 2] == GetParam()->usb->in_endpoint;
  }
  EXPECT_EQ(at, configuration.size());
  EXPECT_EQ(interfaces, configuration[4]);
  EXPECT_TRUE(has_in_endpoint);
  EXPECT_THAT(requests_.usbip_record(false), SizeIs(312));
  EXPECT_THAT(requests_.usbip_record(true), SizeIs(312 + 4 * interfaces));
}

TEST_P(Requests, TakeAConfigurationAndStallOnTheUnknown) {
  EXPECT_EQ(control({0x00, 9, 1, 0, 0, 0, 0, 0}), Bytes{});
  EXPECT_FALSE(control({0x40, 0xEE, 0, 0, 0, 0, 0, 0}));
}

}  // namespace
}  // namespace slipd::devices
