// Writes MCAP files (mcap.dev/spec, version 0) of profile `ros2`: CDR messages in chunks that are compressed
// by LZ4, with message indexes, chunk indexes, statistics, summary offsets and checksums. One thread at a
// time.
//
// A file that was not closed, as after a loss of power, lacks its summary and its last chunk: readers that
// search from the beginning still read the rest.
#pragma once

#include <boost/crc.hpp>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bridges/ros2/mcap/mcap_error.hpp"
#include "bridges/ros2/messages/definition.hpp"

namespace slipd::ros2 {

struct McapOptions {
  // The program that writes, for people.
  std::string library = "slipd";
  // A chunk ends after so many bytes before compression. Fewer: compresses worse. More: readers that seek
  // read more.
  std::size_t chunk_bytes = std::size_t{1} << 20;
  // A chunk ends before its messages span more, ns. Shorter: compresses worse. Longer: more is lost with
  // power.
  std::uint64_t chunk_ns = 5'000'000'000;
  // Replaces a file that exists.
  bool overwrite = false;
};

class McapWriter {
 public:
  // Creates the file. Throws McapError, also if it exists, unless options say otherwise.
  McapWriter(std::string file, McapOptions options);
  // Closes; an error is ignored.
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  // A topic, "/slipd/left/margin", of the first definition's type. `type_hash`: 64 hexadecimal digits.
  // Returns the channel's number. Throws McapError.
  std::uint16_t add_channel(std::string_view topic, const std::vector<Definition>& definitions,
                            std::string_view type_hash);
  template <Message T>
  std::uint16_t add_channel(std::string_view topic) {
    return add_channel(topic, definitions_of<T>(), T::kTypeHash);
  }

  // Appends a message: `cdr` with its header, `time_ns` since 1970. Throws McapError.
  void write(std::uint16_t channel, std::uint64_t time_ns, std::span<const std::uint8_t> cdr);
  // Writes the last chunk and the summary. Nothing can be written any more. Throws McapError.
  void close();

 private:
  using Bytes = std::vector<std::uint8_t>;
  struct Channel {
    Bytes record;  // with its opcode
    std::uint32_t messages = 0;
  };
  struct IndexEntry {
    std::uint64_t time_ns = 0;
    std::uint64_t offset = 0;  // in the chunk before compression
  };

  void end_chunk();
  void append_indexes(std::uint64_t chunk_at, std::uint64_t chunk_bytes, std::size_t compressed_bytes);
  void write_summary();
  Bytes statistics() const;
  // Writes bytes and counts them in the checksum of the section.
  void put(std::span<const std::uint8_t> bytes);

  std::string file_;
  McapOptions options_;
  int fd_ = -1;
  std::uint64_t written_ = 0;
  boost::crc_32_type crc_;  // of the section that is written now

  std::vector<Bytes> schemas_;                       // records
  std::map<std::string, std::uint16_t> schema_ids_;  // by message name
  std::vector<Channel> channels_;
  std::vector<Bytes> chunk_indexes_;  // records

  // The chunk that is filled now.
  Bytes chunk_;
  std::map<std::uint16_t, std::vector<IndexEntry>> chunk_messages_;
  std::uint64_t chunk_first_ns_ = 0, chunk_last_ns_ = 0;
  Bytes compressed_;

  std::uint64_t messages_ = 0, first_ns_ = 0, last_ns_ = 0;
};

}  // namespace slipd::ros2
