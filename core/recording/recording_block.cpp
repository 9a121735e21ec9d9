#include "core/recording/recording_block.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include "core/storage/cbor.hpp"
#include "core/storage/checksum.hpp"

namespace slipd {
namespace {

using Mark = std::array<std::uint8_t, kItemMarkBytes>;

constexpr std::size_t kInteger = 9;     // bytes of an integer of fixed width
constexpr std::size_t kStringHead = 5;  // bytes before a byte string of fixed width
constexpr std::uint64_t kBlockEntries = 8;
constexpr std::uint64_t kIndexEntries = 7;
constexpr std::size_t kEntryBytes = 16;  // of an IndexEntry: two integers of 64 bits, little-endian
constexpr Mark kBlockMark{0xA8, 0x65, 'b', 'l', 'o', 'c', 'k', 0x1B};
constexpr Mark kIndexMark{0xA7, 0x65, 'i', 'n', 'd', 'e', 'x', 0x5A};

// Bytes of a map's entry with a short name.
constexpr std::size_t entry_bytes(std::string_view name, std::size_t value) {
  return 1 + name.size() + value;
}

constexpr std::size_t kBlockHeadBytes = 1 + entry_bytes("block", kInteger) + entry_bytes("of", kInteger) +
                                        entry_bytes("frames", kInteger) + entry_bytes("before", kInteger) +
                                        entry_bytes("first_ns", kInteger) + entry_bytes("last_ns", kInteger) +
                                        entry_bytes("body", kStringHead);
constexpr std::size_t kSumBytes = entry_bytes("xxh3", kInteger);
constexpr std::size_t kPositionBytes = entry_bytes("index_at", kInteger);

bool begins_with(std::span<const std::uint8_t> bytes, const Mark& mark) noexcept {
  return bytes.size() >= mark.size() && std::equal(mark.begin(), mark.end(), bytes.begin());
}

// Whether the checksum that `in` comes to next covers what was read before.
bool sum_fits(cbor::Reader& in, std::span<const std::uint8_t> bytes) noexcept {
  const std::size_t covered = in.position();
  in.text("xxh3");
  const std::uint64_t sum = in.unsigned_integer();
  return in.ok() && sum == xxh3(bytes.first(covered));
}

struct IndexView {
  IndexNumbers numbers;
  std::span<const std::uint8_t> entries, header;
};

std::optional<IndexView> index_view(std::span<const std::uint8_t> bytes) noexcept {
  if (!begins_with(bytes, kIndexMark)) return std::nullopt;
  IndexView view;
  cbor::Reader in(bytes);
  in.map();
  in.text("index");
  view.entries = in.byte_string();
  in.text("of");
  view.numbers.of = in.unsigned_integer();
  in.text("blocks");
  view.numbers.blocks = in.unsigned_integer();
  in.text("frames");
  view.numbers.frames = in.unsigned_integer();
  in.text("header");
  view.header = in.byte_string();
  if (!sum_fits(in, bytes)) return std::nullopt;
  in.text("index_at");
  in.unsigned_integer();
  if (!in.ok()) return std::nullopt;
  return view;
}

}  // namespace

std::size_t block_head_bytes() noexcept {
  return kBlockHeadBytes;
}

std::size_t block_tail_bytes() noexcept {
  return kSumBytes;
}

void seal_block(std::span<std::uint8_t> block, const BlockHead& head) noexcept {
  cbor::Writer out(block.data());
  out.map(kBlockEntries);
  out.text("block");
  out.fixed_unsigned(head.number);
  out.text("of");
  out.fixed_unsigned(head.of);
  out.text("frames");
  out.fixed_unsigned(head.frames);
  out.text("before");
  out.fixed_unsigned(head.before);
  out.text("first_ns");
  out.fixed_integer(head.first_ns);
  out.text("last_ns");
  out.fixed_integer(head.last_ns);
  out.text("body");
  const std::size_t body = block.size() - kBlockHeadBytes - kSumBytes;
  out.fixed_bytes_head(body);
  out.pass_over(body);
  const std::uint64_t sum = xxh3(block.first(kBlockHeadBytes + body));
  out.text("xxh3");
  out.fixed_unsigned(sum);
}

std::optional<WholeBlock> whole_block(std::span<const std::uint8_t> bytes) noexcept {
  if (!begins_with(bytes, kBlockMark)) return std::nullopt;
  WholeBlock block;
  cbor::Reader in(bytes);
  in.map();
  in.text("block");
  block.head.number = in.unsigned_integer();
  in.text("of");
  block.head.of = in.unsigned_integer();
  in.text("frames");
  block.head.frames = in.unsigned_integer();
  in.text("before");
  block.head.before = in.unsigned_integer();
  in.text("first_ns");
  block.head.first_ns = in.integer();
  in.text("last_ns");
  block.head.last_ns = in.integer();
  in.text("body");
  block.body_bytes = in.byte_string().size();
  if (!in.ok() || in.position() != kBlockHeadBytes + block.body_bytes || !sum_fits(in, bytes))
    return std::nullopt;
  if (in.position() != kBlockHeadBytes + block.body_bytes + kSumBytes) return std::nullopt;
  return block;
}

std::vector<std::uint8_t> index_bytes(const RecordingIndex& index, std::uint64_t at) {
  const std::size_t list = index.entries.size() * kEntryBytes;
  std::vector<std::uint8_t> bytes(1 + entry_bytes("index", kStringHead) + list + entry_bytes("of", kInteger) +
                                  entry_bytes("blocks", kInteger) + entry_bytes("frames", kInteger) +
                                  entry_bytes("header", kStringHead) + index.header.size() + kSumBytes +
                                  kPositionBytes);
  cbor::Writer out(bytes.data());
  out.map(kIndexEntries);
  out.text("index");
  out.fixed_bytes_head(list);
  for (const IndexEntry& entry : index.entries) {
    std::array<std::uint8_t, kEntryBytes> pair{};
    std::memcpy(pair.data(), &entry.offset, sizeof entry.offset);
    std::memcpy(pair.data() + sizeof entry.offset, &entry.first_ns, sizeof entry.first_ns);
    out.bytes(pair);
  }
  out.text("of");
  out.fixed_unsigned(index.of);
  out.text("blocks");
  out.fixed_unsigned(index.blocks);
  out.text("frames");
  out.fixed_unsigned(index.frames);
  out.text("header");
  out.fixed_bytes_head(index.header.size());
  out.bytes(index.header);
  const std::uint64_t sum = xxh3(std::span(bytes).first(static_cast<std::size_t>(out.at() - bytes.data())));
  out.text("xxh3");
  out.fixed_unsigned(sum);
  out.text("index_at");
  out.fixed_unsigned(at);
  return bytes;
}

std::optional<IndexNumbers> whole_index(std::span<const std::uint8_t> bytes) noexcept {
  const auto view = index_view(bytes);
  return view ? std::optional(view->numbers) : std::nullopt;
}

std::optional<RecordingIndex> read_index(std::span<const std::uint8_t> bytes) {
  const auto view = index_view(bytes);
  if (!view) return std::nullopt;
  RecordingIndex index{.of = view->numbers.of,
                       .blocks = view->numbers.blocks,
                       .frames = view->numbers.frames,
                       .entries = std::vector<IndexEntry>(view->entries.size() / kEntryBytes),
                       .header = {view->header.begin(), view->header.end()}};
  for (std::size_t i = 0; i < index.entries.size(); ++i) {
    const std::uint8_t* const pair = view->entries.data() + i * kEntryBytes;
    std::memcpy(&index.entries[i].offset, pair, sizeof index.entries[i].offset);
    std::memcpy(&index.entries[i].first_ns, pair + sizeof index.entries[i].offset,
                sizeof index.entries[i].first_ns);
  }
  return index;
}

std::size_t index_position_bytes() noexcept {
  return kPositionBytes;
}

std::optional<std::uint64_t> index_position(std::span<const std::uint8_t> last_bytes) noexcept {
  if (last_bytes.size() < kPositionBytes) return std::nullopt;
  cbor::Reader in(last_bytes.last(kPositionBytes));
  in.text("index_at");
  const std::uint64_t at = in.unsigned_integer();
  return in.ok() && in.position() == kPositionBytes ? std::optional(at) : std::nullopt;
}

std::size_t find_item(std::span<const std::uint8_t> bytes, std::size_t from) noexcept {
  for (std::size_t at = from; at + kItemMarkBytes <= bytes.size(); ++at) {
    const void* const next =
        std::memchr(bytes.data() + at, 0x65, bytes.size() - at);  // the second of each mark
    if (next == nullptr) break;
    const auto second = static_cast<std::size_t>(static_cast<const std::uint8_t*>(next) - bytes.data());
    at = std::max(at, second > 0 ? second - 1 : second);
    const auto rest = bytes.subspan(at);
    if (begins_with(rest, kBlockMark) || begins_with(rest, kIndexMark)) return at;
  }
  return bytes.size();
}

}  // namespace slipd
