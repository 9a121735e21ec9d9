// Encodes and decodes what surrounds the frames of a recording of version 2: blocks and the index;
// recording.hpp describes their form. Any bytes may be decoded: what is returned was covered by a checksum
// that fits. Nothing but index_bytes and read_index allocates; nothing else throws. Called from any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace slipd {

// Bytes of frames in a block, unless a single frame is larger. Smaller: more bytes beside the frames. Larger:
// a damage costs more frames.
inline constexpr std::size_t kBlockBytes = std::size_t{64} * 1024;

// What a block says of its frames.
struct BlockHead {
  // Number of the block, from 0.
  std::uint64_t number = 0;
  // Checksum of the recording's header, which tells its blocks from those of others.
  std::uint64_t of = 0;
  // Frames in it.
  std::uint64_t frames = 0;
  // Frames in the blocks before it.
  std::uint64_t before = 0;
  // time_ns of its first and of its last frame.
  std::int64_t first_ns = 0;
  std::int64_t last_ns = 0;
};

// Bytes before and after the frames of a block.
std::size_t block_head_bytes() noexcept;
std::size_t block_tail_bytes() noexcept;

// Completes a block: `block` has room for the head, then the frames, then room for the tail.
void seal_block(std::span<std::uint8_t> block, const BlockHead& head) noexcept;

// A block that is whole.
struct WholeBlock {
  BlockHead head;
  // Its frames.
  std::size_t body_bytes = 0;
};
// The block that begins with the first of `bytes` and is wholly within them; none: there is none, or its
// checksum does not fit.
std::optional<WholeBlock> whole_block(std::span<const std::uint8_t> bytes) noexcept;

// One place in the file where a block begins.
struct IndexEntry {
  // Position in the file, bytes.
  std::uint64_t offset = 0;
  // time_ns of the block's first frame.
  std::int64_t first_ns = 0;
};

// The end of a recording that was finished.
struct RecordingIndex {
  // BlockHead::of of all blocks.
  std::uint64_t of = 0;
  // Numbers of blocks and of frames.
  std::uint64_t blocks = 0;
  std::uint64_t frames = 0;
  // Some of the blocks in their order, the first one among them.
  std::vector<IndexEntry> entries;
  // Copy of the recording's header, the first item of the file.
  std::vector<std::uint8_t> header;
};

// The index as bytes; `at`: its position in the file.
std::vector<std::uint8_t> index_bytes(const RecordingIndex& index, std::uint64_t at);
// The whole index that begins with the first of `bytes`; none: there is none, or its checksum does not fit.
std::optional<RecordingIndex> read_index(std::span<const std::uint8_t> bytes);
// The numbers of that index, without its lists; none: as read_index.
struct IndexNumbers {
  std::uint64_t of = 0;
  std::uint64_t blocks = 0;
  std::uint64_t frames = 0;
};
std::optional<IndexNumbers> whole_index(std::span<const std::uint8_t> bytes) noexcept;
// Position of the index by the last bytes of a file; none: they are not those of an index.
std::optional<std::uint64_t> index_position(std::span<const std::uint8_t> last_bytes) noexcept;
// How many of the last bytes index_position needs.
std::size_t index_position_bytes() noexcept;

// Where in `bytes` a block or an index may begin, at or after `from`; bytes.size(): nowhere.
std::size_t find_item(std::span<const std::uint8_t> bytes, std::size_t from) noexcept;
// Bytes that find_item needs to recognise an item.
inline constexpr std::size_t kItemMarkBytes = 8;

}  // namespace slipd
