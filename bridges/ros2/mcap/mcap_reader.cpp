#include "bridges/ros2/mcap/mcap_reader.hpp"

#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <boost/crc.hpp>
#include <memory>
#include <utility>

#include "bridges/ros2/mcap/mcap_record.hpp"
#include "wire/number.hpp"

namespace slipd::ros2 {
namespace {

// Bytes that one compressed byte can become: zstd repeats a byte 128 KiB with 4 bytes. Smaller: chunks of a
// picture that stands still are refused. Larger: memory for a hostile file.
constexpr std::uint64_t kMostExpansion = 40'000;
constexpr std::size_t kHeadBytes = 9;  // of a record: opcode and length

// Takes numbers and texts from the front of a record's content.
class Fields {
 public:
  explicit Fields(std::span<const std::uint8_t> bytes) : left_(bytes) {}

  template <std::unsigned_integral T>
  T number() {
    const auto bytes = raw(sizeof(T));
    return whole_ ? static_cast<T>(wire::read_bits(bytes.data(), sizeof(T), false)) : T{0};
  }
  std::string_view text() {
    const auto bytes = raw(number<std::uint32_t>());
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  std::span<const std::uint8_t> raw(std::uint64_t bytes) {
    whole_ = whole_ && bytes <= left_.size();
    if (!whole_) return {};
    const auto taken = left_.first(static_cast<std::size_t>(bytes));
    left_ = left_.subspan(taken.size());
    return taken;
  }
  std::span<const std::uint8_t> rest() const { return left_; }
  bool whole() const { return whole_; }

 private:
  std::span<const std::uint8_t> left_;
  bool whole_ = true;
};

// Fills all of `out`; false: the bytes are damaged, or of another size.
bool unpack_lz4(std::span<const std::uint8_t> in, std::span<std::uint8_t> out) {
  LZ4F_dctx* made = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&made, LZ4F_VERSION)) != 0) return false;
  const std::unique_ptr<LZ4F_dctx, LZ4F_errorCode_t (*)(LZ4F_dctx*)> context(made,
                                                                             LZ4F_freeDecompressionContext);
  std::size_t more = 1;
  while (more != 0) {
    std::size_t taken = in.size(), made_bytes = out.size();
    more = LZ4F_decompress(context.get(), out.data(), &made_bytes, in.data(), &taken, nullptr);
    if (LZ4F_isError(more) != 0 || (taken == 0 && made_bytes == 0)) return false;
    in = in.subspan(taken);
    out = out.subspan(made_bytes);
  }
  return out.empty();
}

bool unpack_zstd(std::span<const std::uint8_t> in, std::span<std::uint8_t> out) {
  return ZSTD_decompress(out.data(), out.size(), in.data(), in.size()) == out.size();
}

bool is_op(std::uint8_t op, McapOp wanted) {
  return op == static_cast<std::uint8_t>(wanted);
}

}  // namespace

McapReader::McapReader(std::istream& in, std::string name) : in_(in), name_(std::move(name)) {
  std::array<std::uint8_t, kMcapMagic.size()> begin{};
  in_.read(reinterpret_cast<char*>(begin.data()), begin.size());
  if (!in_ || begin != kMcapMagic) throw McapError(name_ + ": is no MCAP file");
  at_ = kMcapMagic.size();
}

bool McapReader::fail(const std::string& what) {
  if (fault_.empty()) fault_ = name_ + ": byte " + std::to_string(at_) + ": " + what;
  return false;
}

bool McapReader::next_of_file(std::uint8_t& op, Bytes& content) {
  at_ += record_.empty() ? 0 : kHeadBytes + record_.size();
  std::array<std::uint8_t, kHeadBytes> head{};
  in_.read(reinterpret_cast<char*>(head.data()), head.size());
  op = head[0];
  const std::uint64_t bytes = wire::read_bits(head.data() + 1, sizeof(std::uint64_t), false);
  record_.clear();
  if (!in_) return fail("the file was cut here");
  if (bytes > kLargestRecord) return fail("a record of " + std::to_string(bytes) + " bytes is too long");
  // In steps, so that memory grows with what is there, whatever the length says.
  constexpr std::uint64_t kStep = std::uint64_t{1} << 20;
  while (record_.size() < bytes) {
    const std::size_t had = record_.size();
    record_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(bytes, had + kStep)));
    in_.read(reinterpret_cast<char*>(record_.data() + had),
             static_cast<std::streamsize>(record_.size() - had));
    if (!in_) return fail("the file was cut within a record");
  }
  content = record_;
  if (bytes == 0) at_ += kHeadBytes;
  return true;
}

bool McapReader::next_of_chunk(std::uint8_t& op, Bytes& content) {
  Fields fields(chunk_left_);
  op = fields.number<std::uint8_t>();
  content = fields.raw(fields.number<std::uint64_t>());
  chunk_left_ = fields.rest();
  if (fields.whole()) return true;
  chunk_left_ = {};
  return fail("the chunk has a record that is cut off");
}

// False: it is damaged, and is passed over.
bool McapReader::open_chunk(Bytes content) {
  Fields fields(content);
  fields.number<std::uint64_t>();  // first and last time
  fields.number<std::uint64_t>();
  const auto bytes = fields.number<std::uint64_t>();
  const auto crc = fields.number<std::uint32_t>();
  const std::string compression(fields.text());
  const Bytes packed = fields.raw(fields.number<std::uint64_t>());
  if (!fields.whole() || bytes > kLargestRecord || bytes > kMostExpansion * packed.size())
    return fail("the chunk is damaged");
  if (compression.empty()) {
    chunk_.assign(packed.begin(), packed.end());
  } else if (compression == "lz4" || compression == "zstd") {
    chunk_.resize(static_cast<std::size_t>(bytes));
    if (!(compression == "lz4" ? unpack_lz4(packed, chunk_) : unpack_zstd(packed, chunk_)))
      return fail("the chunk is damaged: " + compression + " cannot read it");
  } else {
    throw McapError(name_ + ": its chunks are compressed by \"" + compression + "\"; known: lz4, zstd");
  }
  boost::crc_32_type now;
  now.process_bytes(chunk_.data(), chunk_.size());
  if (chunk_.size() != bytes || (crc != 0 && now.checksum() != crc))
    return fail("the chunk is damaged: its checksum is another one");
  chunk_left_ = chunk_;
  return true;
}

// True: `out` is filled.
bool McapReader::take(std::uint8_t op, Bytes content, McapMessage& out) {
  Fields fields(content);
  if (is_op(op, McapOp::schema)) {
    const auto id = fields.number<std::uint16_t>();
    const auto name = fields.text();
    if (fields.whole()) schemas_[id] = name;
  } else if (is_op(op, McapOp::channel)) {
    const auto id = fields.number<std::uint16_t>(), schema = fields.number<std::uint16_t>();
    const auto topic = fields.text(), encoding = fields.text();
    if (fields.whole()) channels_[id] = {std::string(topic), std::string(encoding), schema};
  } else if (is_op(op, McapOp::message)) {
    const auto channel = channels_.find(fields.number<std::uint16_t>());
    fields.number<std::uint32_t>();  // sequence: 0 if the recorder knows none
    out.log_ns = fields.number<std::uint64_t>();
    out.publish_ns = fields.number<std::uint64_t>();
    if (!fields.whole() || channel == channels_.end()) return fail("a message of no channel");
    const auto schema = schemas_.find(channel->second.schema);
    out.topic = channel->second.topic;
    out.encoding = channel->second.encoding;
    out.schema = schema == schemas_.end() ? std::string_view() : schema->second;
    out.data = fields.rest();
    return true;
  }
  return false;
}

bool McapReader::next(McapMessage& out) {
  std::uint8_t op = 0;
  Bytes content;
  while (!ended_) {
    if (!chunk_left_.empty()) {
      if (next_of_chunk(op, content) && take(op, content, out)) return true;
      continue;
    }
    // Behind the data are the index and copies of what was read.
    ended_ = !next_of_file(op, content) || is_op(op, McapOp::data_end) || is_op(op, McapOp::footer);
    if (ended_) break;
    if (is_op(op, McapOp::chunk))
      open_chunk(content);
    else if (take(op, content, out))
      return true;
  }
  return false;
}

}  // namespace slipd::ros2
