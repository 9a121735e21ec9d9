#include "bridges/feed/udp_source.hpp"

#include <gtest/gtest.h>

#include <boost/asio/buffer.hpp>
#include <memory>

#include "bridges/feed/reader.hpp"

namespace slipd::feed {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;

std::uint16_t free_port(asio::io_context& context) {
  return udp::socket(context, {asio::ip::address_v4::loopback(), 0}).local_endpoint().port();
}

// Eleven messages of two datagrams come to a lane, the second and third without their last one: the lane's
// account.
Account account_of_torn_messages(bool with_sequence) {
  const std::string text = R"({ "description": "a cell", "tested": "synthetic", "source": "this test",
    "from": "udp://127.0.0.1:9", "format": "bytes", "unit": "N", "axes": 1, "taxels": 1,
    "datagrams": { "header": 3, "message": { "offset": 0, "type": "u8" }, "last": { "offset": 1, "type": "u8" },
                   "part": { "offset": 2, "type": "u8" } },)" +
                           std::string(with_sequence ? R"("sequence": { "offset": 0, "type": "u8" },)" : "") +
                           R"("values": { "offset": 1, "type": "u8" } })";
  const Profile profile = parse_profile(text, "cell", {});
  Lane lane("cell", profile.frames, std::make_unique<Reader>(profile), "/nowhere/slipd.sock");
  asio::io_context context;
  const udp::endpoint here(asio::ip::address_v4::loopback(), free_port(context));
  UdpSource source(context, {Scheme::udp, here.address().to_string(), here.port(), "/"},
                   {{&lane, Assembler(*profile.datagrams, false), "", profile.sequence.has_value()}});
  udp::socket sender(context, udp::v4());
  for (std::uint8_t number = 0; number < 11; ++number)
    for (const std::uint8_t part : {0, 1}) {
      const std::uint8_t datagram[] = {number, 1, part, number};
      if (part == 0 || (number != 1 && number != 2)) sender.send_to(asio::buffer(datagram), here);
    }
  context.run_one();
  return lane.account();
}

TEST(UdpSource, CountsMessagesThatDidNotComeWholeWhereTheSenderCountsNone) {
  const Account account = account_of_torn_messages(false);
  EXPECT_EQ(account.messages, 9U);
  EXPECT_EQ(account.corrupt, 0U);
  EXPECT_EQ(account.lost, 2U);
}

TEST(UdpSource, CountsNoLossTwiceWhereTheSenderCounts) {
  const Account account = account_of_torn_messages(true);
  EXPECT_EQ(account.messages, 9U);
  EXPECT_EQ(account.repeated, 0U);
  EXPECT_EQ(account.lost, 2U);
}

}  // namespace
}  // namespace slipd::feed
