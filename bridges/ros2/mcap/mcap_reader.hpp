// Reads the messages of MCAP files (mcap.dev/spec, version 0) of any writer, in the order of the file: chunks
// without compression, by LZ4 and by zstd, with and without an index. One thread at a time; any bytes are
// valid input.
//
// A file that was cut, as after a loss of power, gives what is whole; fault() then says where it ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bridges/ros2/mcap/mcap_error.hpp"

namespace slipd::ros2 {

// Valid until the next call of the reader.
struct McapMessage {
  std::string_view topic;
  std::string_view schema;       // "std_msgs/msg/Float32MultiArray"; empty: none
  std::string_view encoding;     // "cdr" of ROS 2
  std::uint64_t log_ns = 0;      // when it was recorded, ns since 1970
  std::uint64_t publish_ns = 0;  // when it was published, if the recorder knew; else as log_ns
  std::span<const std::uint8_t> data;
};

class McapReader {
 public:
  // Largest record, and largest chunk before compression, bytes. Smaller: chunks of large pictures are
  // refused. Larger: memory for a hostile file.
  static constexpr std::uint64_t kLargestRecord = std::uint64_t{256} << 20;

  // `in` must live longer. `name` is the file's, for errors. Throws McapError if it is no MCAP file.
  McapReader(std::istream& in, std::string name);

  // False: there is no more. fault() then says whether that is the file's end. Throws McapError for a chunk
  // with a compression that is not known here.
  bool next(McapMessage& out);
  // `FILE: byte N: what is wrong`; empty: nothing was, so far.
  const std::string& fault() const noexcept { return fault_; }

 private:
  struct Channel {
    std::string topic, encoding;
    std::uint16_t schema = 0;
  };
  using Bytes = std::span<const std::uint8_t>;

  bool next_of_file(std::uint8_t& op, Bytes& content);
  bool next_of_chunk(std::uint8_t& op, Bytes& content);
  bool open_chunk(Bytes content);
  bool take(std::uint8_t op, Bytes content, McapMessage& out);
  bool fail(const std::string& what);

  std::istream& in_;
  std::string name_, fault_;
  std::uint64_t at_ = 0;  // of the record that is read, in the file
  bool ended_ = false;
  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  std::vector<std::uint8_t> record_, chunk_;
  Bytes chunk_left_;
};

}  // namespace slipd::ros2
