// Any bytes as an MCAP file: it is refused with a reason, or gives messages whose bytes are there, up to the
// end or to a reported fault.
#include <numeric>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "bridges/ros2/mcap/mcap_reader.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

constexpr std::uint64_t kLargestByte = 255;

std::uint64_t sum_of(std::span<const std::uint8_t> bytes) {
  return std::accumulate(bytes.begin(), bytes.end(), std::uint64_t{0});
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slipd::ros2;
  using slipd::fuzz::demand;
  std::istringstream in(std::string(data, data + size));
  try {
    McapReader reader(in, "fuzz");
    McapMessage message;
    while (reader.next(message)) {
      demand(message.data.size() <= McapReader::kLargestRecord);
      demand(sum_of(message.data) <= kLargestByte * message.data.size());  // each byte is read
      for (const std::string_view text : {message.topic, message.schema, message.encoding})
        demand(sum_of(std::vector<std::uint8_t>(text.begin(), text.end())) <= kLargestByte * text.size());
    }
    demand(!reader.next(message));  // and does not change
  } catch (const McapError& error) {
    demand(*error.what() != '\0');
  }
  return 0;
}
