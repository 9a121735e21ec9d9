#include <algorithm>
#include <new>

#include "core/recording/recording.hpp"
#include "core/recording/recording_frame.hpp"
#include "core/recording/recording_header.hpp"
#include "core/storage/checksum.hpp"

namespace slipd {
namespace {

constexpr std::size_t kGather = std::size_t{1} << 20;  // bytes that are written at once
// Entries of an index at most; a longer recording has entries further apart. More: a larger index in memory.
constexpr std::size_t kMostIndexEntries = 2048;

std::size_t largest_block_bytes(std::size_t taxels) {
  return block_head_bytes() + std::max(kBlockBytes, largest_frame_bytes(taxels)) + block_tail_bytes();
}

}  // namespace

RecordingWriter::RecordingWriter(int fd, const RecordingHeader& header, std::chrono::milliseconds flush_after,
                                 std::optional<OutputPatience> patience)
    : fd_(fd),
      patience_(patience),
      taxels_(header.layout.size()),
      flush_after_(flush_after),
      flushed_(std::chrono::steady_clock::now()) {
  index_.header = encode_header(header);
  index_.of = xxh3(index_.header);
  index_.entries.reserve(kMostIndexEntries);
  memory_.resize(std::max(kGather, index_.header.size() + largest_block_bytes(taxels_)));
  std::copy(index_.header.begin(), index_.header.end(), memory_.begin());
  size_ = index_.header.size();
}

RecordingWriter::~RecordingWriter() {
  finish();
}

std::error_code RecordingWriter::append(const FrameSlot& frame, const RecordedEstimate* estimate) noexcept {
  if (finished_ || frame.normal_pa.size() != taxels_ || frame.shear_x_pa.size() != taxels_ ||
      frame.shear_y_pa.size() != taxels_) {
    return std::make_error_code(std::errc::invalid_argument);
  }
  if (error_) return error_;
  const std::size_t body = size_ - block_begin_ - block_head_bytes();
  if (block_.frames > 0 && body + largest_frame_bytes(taxels_) > kBlockBytes) end_block();
  if (block_.frames == 0) begin_block();
  if (error_) return error_;
  cbor::Writer out(memory_.data() + size_);
  put_frame(out, frame, estimate);
  size_ = static_cast<std::size_t>(out.at() - memory_.data());
  if (block_.frames++ == 0) block_.first_ns = frame.time_ns;
  block_.last_ns = frame.time_ns;
  if (std::chrono::steady_clock::now() - flushed_ >= flush_after_) flush();
  return error_;
}

void RecordingWriter::begin_block() noexcept {
  if (memory_.size() - size_ < largest_block_bytes(taxels_)) write_out();
  block_begin_ = size_;
  size_ += block_head_bytes();
}

void RecordingWriter::end_block() noexcept {
  size_ += block_tail_bytes();
  block_.number = index_.blocks;
  block_.of = index_.of;
  block_.before = index_.frames;
  seal_block(std::span(memory_).subspan(block_begin_, size_ - block_begin_), block_);
  if (index_.blocks % index_step_ == 0)
    add_to_index({.offset = written_ + block_begin_, .first_ns = block_.first_ns});
  ++index_.blocks;
  index_.frames += block_.frames;
  block_ = {};
}

void RecordingWriter::add_to_index(const IndexEntry& entry) noexcept {
  auto& entries = index_.entries;
  if (entries.size() == kMostIndexEntries) {  // every second one stays
    for (std::size_t i = 1; 2 * i < entries.size(); ++i) entries[i] = entries[2 * i];
    entries.resize((entries.size() + 1) / 2);
    index_step_ *= 2;
    if (index_.blocks % index_step_ != 0) return;
  }
  entries.push_back(entry);  // within its capacity
}

std::error_code RecordingWriter::put(std::span<const std::uint8_t> bytes) const noexcept {
  return patience_ ? send_bounded(fd_, bytes, *patience_) : write_file(fd_, bytes);
}

void RecordingWriter::write_out() noexcept {
  if (!error_) error_ = put(std::span(memory_).first(size_));
  if (!error_) written_ += size_;
  size_ = 0;
}

std::error_code RecordingWriter::flush() noexcept {
  if (block_.frames > 0) end_block();
  write_out();
  flushed_ = std::chrono::steady_clock::now();
  return error_;
}

std::error_code RecordingWriter::finish() noexcept {
  if (finished_) return error_;
  flush();
  finished_ = true;
  if (error_) return error_;
  try {
    const auto bytes = index_bytes(index_, written_);
    error_ = put(bytes);
    if (!error_) written_ += bytes.size();
  } catch (const std::bad_alloc&) {
    error_ = std::make_error_code(std::errc::not_enough_memory);
  }
  return error_;
}

}  // namespace slipd
