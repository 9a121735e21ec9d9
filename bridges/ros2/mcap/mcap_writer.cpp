#include "bridges/ros2/mcap/mcap_writer.hpp"

#include <fcntl.h>
#include <lz4frame.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <system_error>
#include <utility>

#include "bridges/ros2/mcap/mcap_record.hpp"

namespace slipd::ros2 {
namespace {

constexpr mode_t kMode = 0644;

// Of a system call that has set errno.
[[noreturn]] void refuse_file(const std::string& file, const std::string& what) {
  throw McapError(file + ": " + what + ": " + std::generic_category().message(errno));
}

std::uint32_t crc_of(std::span<const std::uint8_t> bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

}  // namespace

McapWriter::McapWriter(std::string file, McapOptions options)
    : file_(std::move(file)), options_(std::move(options)) {
  fd_ =
      ::open(file_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | (options_.overwrite ? O_TRUNC : O_EXCL), kMode);
  if (fd_ < 0 && errno == EEXIST)
    throw McapError(file_ + ": exists already; name another file, or give --force");
  if (fd_ < 0) refuse_file(file_, "cannot create it");
  put(kMcapMagic);
  Bytes header;
  McapRecord(header, McapOp::header).text("ros2").text(options_.library).end();
  put(header);
}

McapWriter::~McapWriter() {
  try {
    close();
  } catch (const std::exception&) {  // who needs to hear of it calls close()
    if (fd_ >= 0) ::close(fd_);
  }
}

std::uint16_t McapWriter::add_channel(std::string_view topic, const std::vector<Definition>& definitions,
                                      std::string_view type_hash) {
  if (channels_.size() >= std::numeric_limits<std::uint16_t>::max())
    throw McapError(file_ + ": more topics than a file may have");
  end_chunk();
  const std::string& name = definitions.front().name;
  const auto [schema, is_new] =
      schema_ids_.try_emplace(name, static_cast<std::uint16_t>(schema_ids_.size() + 1));
  if (is_new) {
    Bytes& record = schemas_.emplace_back();
    McapRecord(record, McapOp::schema)
        .number(schema->second)
        .text(name)
        .text("ros2msg")
        .text(msg_text(definitions))
        .end();
    put(record);
  }
  const auto number = static_cast<std::uint16_t>(channels_.size());
  Bytes& record = channels_.emplace_back().record;
  McapRecord(record, McapOp::channel)
      .number(number)
      .number(schema->second)
      .text(topic)
      .text("cdr")
      .list([&](McapRecord& map) {
        map.text("offered_qos_profiles").text("");
        map.text("topic_type_hash").text("RIHS01_" + std::string(type_hash));
      })
      .end();
  put(record);
  return number;
}

void McapWriter::write(std::uint16_t channel, std::uint64_t time_ns, std::span<const std::uint8_t> cdr) {
  const bool long_enough =
      !chunk_.empty() && time_ns > chunk_first_ns_ && time_ns - chunk_first_ns_ > options_.chunk_ns;
  if (long_enough || chunk_.size() >= options_.chunk_bytes) end_chunk();
  if (chunk_.empty()) chunk_first_ns_ = chunk_last_ns_ = time_ns;
  if (messages_ == 0) first_ns_ = last_ns_ = time_ns;
  chunk_first_ns_ = std::min(chunk_first_ns_, time_ns);
  chunk_last_ns_ = std::max(chunk_last_ns_, time_ns);
  first_ns_ = std::min(first_ns_, time_ns);
  last_ns_ = std::max(last_ns_, time_ns);
  ++messages_;
  chunk_messages_[channel].push_back({time_ns, chunk_.size()});
  McapRecord(chunk_, McapOp::message)
      .number(channel)
      .number(channels_.at(channel).messages++)
      .number(time_ns)
      .number(time_ns)
      .raw(cdr)
      .end();
}

void McapWriter::end_chunk() {
  if (chunk_.empty()) return;
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.contentSize = chunk_.size();
  compressed_.resize(LZ4F_compressFrameBound(chunk_.size(), &preferences));
  const std::size_t bytes =
      LZ4F_compressFrame(compressed_.data(), compressed_.size(), chunk_.data(), chunk_.size(), &preferences);
  if (LZ4F_isError(bytes) != 0) throw McapError(file_ + ": LZ4: " + LZ4F_getErrorName(bytes));
  compressed_.resize(bytes);
  Bytes record;
  McapRecord(record, McapOp::chunk)
      .number(chunk_first_ns_)
      .number(chunk_last_ns_)
      .number(std::uint64_t{chunk_.size()})
      .number(crc_of(chunk_))
      .text("lz4")
      .number(std::uint64_t{bytes})
      .raw(compressed_)
      .end();
  const std::uint64_t chunk_at = written_;
  put(record);
  append_indexes(chunk_at, record.size(), bytes);
  chunk_.clear();
  chunk_messages_.clear();
}

void McapWriter::append_indexes(std::uint64_t chunk_at, std::uint64_t chunk_bytes,
                                std::size_t compressed_bytes) {
  const std::uint64_t indexes_at = written_;
  std::vector<std::pair<std::uint16_t, std::uint64_t>> offsets;
  for (auto& [channel, messages] : chunk_messages_) {
    auto& entries = messages;  // C++20 lets no lambda capture a structured binding by reference in clang 14
    std::stable_sort(entries.begin(), entries.end(),
                     [](const IndexEntry& a, const IndexEntry& b) { return a.time_ns < b.time_ns; });
    offsets.emplace_back(channel, written_);
    Bytes record;
    McapRecord(record, McapOp::message_index)
        .number(channel)
        .list([&](McapRecord& list) {
          for (const IndexEntry& entry : entries) list.number(entry.time_ns).number(entry.offset);
        })
        .end();
    put(record);
  }
  McapRecord(chunk_indexes_.emplace_back(), McapOp::chunk_index)
      .number(chunk_first_ns_)
      .number(chunk_last_ns_)
      .number(chunk_at)
      .number(chunk_bytes)
      .list([&](McapRecord& map) {
        for (const auto& [channel, offset] : offsets) map.number(channel).number(offset);
      })
      .number(written_ - indexes_at)
      .text("lz4")
      .number(std::uint64_t{compressed_bytes})
      .number(std::uint64_t{chunk_.size()})
      .end();
}

McapWriter::Bytes McapWriter::statistics() const {
  Bytes record;
  McapRecord(record, McapOp::statistics)
      .number(messages_)
      .number(static_cast<std::uint16_t>(schemas_.size()))
      .number(static_cast<std::uint32_t>(channels_.size()))
      .number(std::uint32_t{0})  // attachments
      .number(std::uint32_t{0})  // metadata
      .number(static_cast<std::uint32_t>(chunk_indexes_.size()))
      .number(first_ns_)
      .number(last_ns_)
      .list([&](McapRecord& map) {
        for (std::size_t i = 0; i < channels_.size(); ++i)
          map.number(static_cast<std::uint16_t>(i)).number(std::uint64_t{channels_[i].messages});
      })
      .end();
  return record;
}

void McapWriter::write_summary() {
  struct Group {
    McapOp op;
    std::uint64_t at = 0, bytes = 0;
  };
  std::vector<Group> groups;
  const auto put_group = [&](McapOp op, const std::vector<Bytes>& records) {
    if (records.empty()) return;
    const std::uint64_t at = written_;
    for (const Bytes& record : records) put(record);
    groups.push_back({op, at, written_ - at});
  };
  std::vector<Bytes> channels;
  for (const Channel& channel : channels_) channels.push_back(channel.record);
  const std::uint64_t summary_at = written_;
  put_group(McapOp::schema, schemas_);
  put_group(McapOp::channel, channels);
  put_group(McapOp::statistics, {statistics()});
  put_group(McapOp::chunk_index, chunk_indexes_);
  const std::uint64_t offsets_at = written_;
  for (const Group& group : groups) {
    Bytes record;
    McapRecord(record, McapOp::summary_offset)
        .number(static_cast<std::uint8_t>(group.op))
        .number(group.at)
        .number(group.bytes)
        .end();
    put(record);
  }
  // The checksum counts all of the footer before itself.
  Bytes footer;
  McapRecord(footer, McapOp::footer).number(summary_at).number(offsets_at).number(std::uint32_t{0}).end();
  footer.resize(footer.size() - sizeof(std::uint32_t));
  put(footer);
  const std::uint32_t crc = crc_.checksum();
  std::array<std::uint8_t, sizeof crc> last{};
  std::memcpy(last.data(), &crc, sizeof crc);
  put(last);
}

void McapWriter::close() {
  if (fd_ < 0) return;
  end_chunk();
  Bytes data_end;
  McapRecord(data_end, McapOp::data_end).number(static_cast<std::uint32_t>(crc_.checksum())).end();
  put(data_end);
  crc_.reset();
  write_summary();
  put(kMcapMagic);
  const int fd = std::exchange(fd_, -1);
  if (::close(fd) != 0) refuse_file(file_, "cannot write it");
}

void McapWriter::put(std::span<const std::uint8_t> bytes) {
  crc_.process_bytes(bytes.data(), bytes.size());
  written_ += bytes.size();
  while (!bytes.empty()) {
    const ssize_t did = ::write(fd_, bytes.data(), bytes.size());
    if (did < 0 && errno == EINTR) continue;
    if (did < 0) refuse_file(file_, "cannot write it");
    bytes = bytes.subspan(static_cast<std::size_t>(did));
  }
}

}  // namespace slipd::ros2
