#include <algorithm>
#include <cerrno>
#include <utility>

#include "core/recording/recording.hpp"
#include "core/recording/recording_frame.hpp"
#include "core/recording/recording_header.hpp"
#include "core/storage/checksum.hpp"

namespace slipd {
namespace {

constexpr std::size_t kFirstLook = std::size_t{1} << 14;
constexpr std::size_t kMostIndexBytes = std::size_t{2} << 20;
constexpr std::uint64_t kMostSkips = 1'000'000;  // damaged blocks that are returned one by one

}  // namespace

RecordingReader::RecordingReader(const std::filesystem::path& file)
    : path_(file), file_(file, kFirstLook), header_(read_header()) {
  const std::size_t frame = largest_frame_bytes(header_.layout.size());
  item_bytes_ = block_head_bytes() + std::max(kBlockBytes, frame) + block_tail_bytes();
  if (version_ == 2) item_bytes_ = std::max(item_bytes_, kFirstLook + kMostIndexBytes / 32);
  if (index_)
    item_bytes_ = std::max(item_bytes_, static_cast<std::size_t>(first_frame_) + kMostIndexBytes / 32);
  file_.reserve(2 * (version_ == 1 ? frame : item_bytes_));
  rewind();
}

RecordingHeader RecordingReader::read_header() {
  try {
    RecordingHeader header = header_at_start();
    if (version_ == 2) load_index();
    return header;
  } catch (const RecordingError&) {
    if (auto header = header_of_index()) return *std::move(header);
    throw;
  }
}

RecordingHeader RecordingReader::header_at_start() {
  const auto refuse = [this](std::uint64_t offset, const std::string& what) -> RecordingError {
    return {path_.string() + ": byte " + std::to_string(offset) + ": " + what, offset};
  };
  auto bytes = file_.peek(file_.capacity());
  if (file_.error() != 0) throw std::system_error(file_.error(), std::generic_category(), path_.string());
  if (bytes.empty()) throw refuse(0, "the file is empty, expected a slipd recording");
  if (bytes[0] >> 5 != 5) throw refuse(0, "not a slipd recording: expected a CBOR map as its header");
  cbor::Reader item(bytes);
  item.skip();
  while (item.starved() && bytes.size() == file_.capacity() && file_.capacity() < kRecordingMaxHeaderBytes) {
    file_.reserve(2 * file_.capacity());
    bytes = file_.peek(file_.capacity());
    item = cbor::Reader(bytes);
    item.skip();
  }
  if (!item.ok()) {
    throw refuse(item.starved() ? bytes.size() : item.position(),
                 item.starved() ? "the file ends within the header of the recording"
                                : "the header is no sound CBOR map");
  }
  first_frame_ = item.position();
  try {
    const auto encoded = bytes.first(item.position());
    DecodedHeader decoded = decode_header(encoded);
    version_ = decoded.version;
    of_ = xxh3(encoded);
    return std::move(decoded.header);
  } catch (const std::invalid_argument& e) {
    throw refuse(0, e.what());
  }
}

// For a header that is damaged.
std::optional<RecordingHeader> RecordingReader::header_of_index() {
  load_index();
  if (!index_ || index_->of != xxh3(index_->header)) return std::nullopt;
  try {
    DecodedHeader decoded = decode_header(index_->header);
    if (decoded.version != 2) return std::nullopt;
    of_ = index_->of;
    header_damaged_ = true;
    first_frame_ = index_->entries.empty() ? index_->header.size() : index_->entries.front().offset;
    return std::move(decoded.header);
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

// As far as the end of the file is one.
void RecordingReader::load_index() {
  const std::uint64_t size = file_.size();
  std::vector<std::uint8_t> bytes(index_position_bytes());
  if (size < bytes.size() || !file_.read_at(size - bytes.size(), bytes)) return;
  const auto at = index_position(bytes);
  if (!at || *at >= size || size - *at > kMostIndexBytes) return;
  bytes.resize(static_cast<std::size_t>(size - *at));
  if (!file_.read_at(*at, bytes)) return;
  index_ = read_index(bytes);
}

void RecordingReader::note(Trouble trouble, std::uint64_t offset) noexcept {
  if (trouble_ != Trouble::none) return;
  trouble_ = trouble;
  fault_offset_ = offset;
}

RecordingReader::Status RecordingReader::fail(Trouble trouble, std::uint64_t offset,
                                              const char* expected) noexcept {
  trouble_ = trouble;
  fault_offset_ = offset;
  expected_ = expected;
  return status_ = Status::damaged;
}

RecordingReader::Status RecordingReader::next(FrameSlot& out,
                                              std::optional<RecordedEstimate>* estimate) noexcept {
  if (estimate != nullptr) estimate->reset();
  if (status_ == Status::damaged) return status_;
  const std::size_t taxels = header_.layout.size();
  if (out.normal_pa.size() != taxels || out.shear_x_pa.size() != taxels || out.shear_y_pa.size() != taxels)
    return fail(Trouble::v1_damaged, file_.offset(), "a slot of the layout's size to read into");
  return version_ == 1 ? next_of_sequence(out, estimate) : next_of_blocks(out, estimate);
}

RecordingReader::Status RecordingReader::next_frame(FrameSlot& out,
                                                    std::optional<RecordedEstimate>* estimate) noexcept {
  Status status = next(out, estimate);
  while (status == Status::skipped || status == Status::searching) status = next(out, estimate);
  return status;
}

// Version 1: frames without blocks.
RecordingReader::Status RecordingReader::next_of_sequence(
    FrameSlot& out, std::optional<RecordedEstimate>* estimate) noexcept {
  if (status_ != Status::frame) return status_;
  const auto bytes = file_.peek(largest_frame_bytes(header_.layout.size()));
  if (file_.error() != 0)
    return fail(Trouble::unreadable, file_.offset() + bytes.size(), "to be able to read on");
  if (bytes.empty()) return status_ = Status::end;
  cbor::Reader in(bytes);
  if (const char* const expected = take_frame(in, out, estimate)) {
    if (estimate != nullptr) estimate->reset();
    return fail(in.starved() ? Trouble::v1_cut : Trouble::v1_damaged,
                file_.offset() + (in.starved() ? bytes.size() : in.position()), expected);
  }
  file_.consume(in.position());
  return status_;
}

RecordingReader::Status RecordingReader::next_of_blocks(FrameSlot& out,
                                                        std::optional<RecordedEstimate>* estimate) noexcept {
  for (;;) {
    if (skips_due_ > 0) {
      --skips_due_;
      return Status::skipped;
    }
    if (frames_left_ > 0) return take_frame_of_block(out, estimate);
    if (status_ != Status::frame) return status_;
    const Status found = searching_ ? search() : take_item();
    if (found != Status::frame) return found;
  }
}

// The checksum of the present block fits.
RecordingReader::Status RecordingReader::take_frame_of_block(
    FrameSlot& out, std::optional<RecordedEstimate>* estimate) noexcept {
  const auto bytes = file_.peek(body_left_);
  cbor::Reader in(bytes.first(std::min(bytes.size(), body_left_)));
  if (take_frame(in, out, estimate) != nullptr) {  // written by another program
    if (estimate != nullptr) estimate->reset();
    note(Trouble::damaged, file_.offset());
    count_damaged(1, frames_left_);
    file_.consume(body_left_ + block_tail_bytes());
    frames_left_ = 0;
    return Status::searching;
  }
  file_.consume(in.position());
  body_left_ -= in.position();
  if (--frames_left_ == 0) file_.consume(body_left_ + block_tail_bytes());
  if (out.time_ns >= from_ns_) return Status::frame;
  if (estimate != nullptr) estimate->reset();
  return Status::searching;
}

// `frame`: an item was taken or a search begins. Else what next() returns.
RecordingReader::Status RecordingReader::take_item() noexcept {
  const auto bytes = file_.peek(item_bytes_);
  if (file_.error() != 0)
    return fail(Trouble::unreadable, file_.offset() + bytes.size(), "to be able to read on");
  if (bytes.empty()) {
    note(Trouble::unfinished, file_.offset());
    return status_ = Status::end;
  }
  if (take_whole_item(bytes)) return Status::frame;
  searching_ = true;
  search_from_ = 1;
  note(Trouble::damaged, file_.offset());
  return Status::frame;
}

// Takes the block or index that `bytes` begin with; false: they begin with none that is whole.
bool RecordingReader::take_whole_item(std::span<const std::uint8_t> bytes) noexcept {
  const bool after_damage = std::exchange(searching_, false);
  if (const auto block = whole_block(bytes);
      block && block->head.of == of_ && (any_number_ || block->head.number >= next_number_)) {
    const BlockHead& head = block->head;
    const std::uint64_t missing = any_number_ ? 0 : head.number - next_number_;
    if (missing > 0) note(Trouble::damaged, file_.offset());
    if (missing > 0 || after_damage) {
      const std::uint64_t frames = head.before > frames_before_ ? head.before - frames_before_ : 0;
      count_damaged(std::max<std::uint64_t>(missing, 1), any_number_ ? 0 : frames);
    }
    any_number_ = false;
    next_number_ = head.number + 1;
    frames_before_ = head.before + head.frames;
    file_.consume(block_head_bytes());
    body_left_ = block->body_bytes;
    frames_left_ = head.frames;
    if (frames_left_ == 0) file_.consume(body_left_ + block_tail_bytes());
    return true;
  }
  if (const auto index = whole_index(bytes); index && index->of == of_) {
    const std::uint64_t missing =
        any_number_ || index->blocks < next_number_ ? 0 : index->blocks - next_number_;
    if (missing > 0) note(Trouble::damaged, file_.offset());
    if (missing > 0 || after_damage) {
      const std::uint64_t frames = index->frames > frames_before_ ? index->frames - frames_before_ : 0;
      count_damaged(std::max<std::uint64_t>(missing, 1), any_number_ ? 0 : frames);
    }
    status_ = Status::end;
    return true;
  }
  searching_ = after_damage;
  return false;
}

void RecordingReader::count_damaged(std::uint64_t blocks, std::uint64_t frames) noexcept {
  damaged_blocks_ += blocks;
  damaged_frames_ += frames;
  skips_due_ += std::min(blocks, kMostSkips);
}

// Looks on for an item behind a damage, in one buffer at most.
RecordingReader::Status RecordingReader::search() noexcept {
  const auto bytes = file_.peek(file_.capacity());
  if (file_.error() != 0)
    return fail(Trouble::unreadable, file_.offset() + bytes.size(), "to be able to read on");
  const std::size_t at = find_item(bytes, search_from_);
  if (at < bytes.size()) {
    file_.consume(at);
    search_from_ = 1;
    return take_whole_item(file_.peek(item_bytes_)) ? Status::frame : Status::searching;
  }
  search_from_ = 0;
  if (bytes.size() < file_.capacity()) {
    end_of_file();
    return Status::frame;
  }
  file_.consume(bytes.size() - (kItemMarkBytes - 1));
  return Status::searching;
}

// Nothing whole follows the damage.
void RecordingReader::end_of_file() noexcept {
  if (damaged_blocks_ == 0) trouble_ = Trouble::cut_within;
  count_damaged(1, 0);
  searching_ = false;
  status_ = Status::end;
}

void RecordingReader::start_at(std::uint64_t offset) noexcept {
  file_.seek(offset);
  status_ = Status::frame;
  next_number_ = frames_before_ = frames_left_ = skips_due_ = 0;
  body_left_ = search_from_ = 0;
  any_number_ = searching_ = false;
  from_ns_ = INT64_MIN;
  damaged_blocks_ = damaged_frames_ = 0;
  trouble_ = Trouble::none;
  fault_offset_ = 0;
  expected_ = nullptr;
}

void RecordingReader::rewind() noexcept {
  start_at(first_frame_);
  if (!header_damaged_) return;
  note(Trouble::damaged, 0);
  count_damaged(1, 0);
}

bool RecordingReader::seek(std::int64_t time_ns) noexcept {
  if (!index_) return false;
  std::uint64_t offset = first_frame_;
  for (const IndexEntry& entry : index_->entries) {
    if (entry.first_ns <= time_ns) offset = entry.offset;
  }
  start_at(offset);
  any_number_ = true;
  from_ns_ = time_ns;
  return true;
}

std::optional<std::uint64_t> RecordingReader::frames() const noexcept {
  return index_ ? std::optional(index_->frames) : std::nullopt;
}

std::string RecordingReader::fault() const {
  const std::string at = path_.string() + ": byte " + std::to_string(fault_offset_) + ": ";
  const std::string frame = "the frame that begins at byte " + std::to_string(file_.offset());
  const auto counted = [](std::uint64_t n, const char* what) {
    return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
  };
  switch (trouble_) {
    case Trouble::none:
      return {};
    case Trouble::damaged:
      return at + "damaged; " + counted(damaged_blocks_, "block") + " with " +
             (damaged_frames_ > 0 ? counted(damaged_frames_, "frame") : "an unknown number of frames") +
             (damaged_blocks_ == 1 ? " is" : " are") + " left out";
    case Trouble::cut_within:
      return at + "the recording ends within what begins here, or is damaged from here on";
    case Trouble::unfinished:
      return at + "the recording ends without its index: it was not finished";
    case Trouble::unreadable:
      return at + std::generic_category().message(file_.error());
    case Trouble::v1_cut:
      return at + "the recording ends within " + frame;
    case Trouble::v1_damaged:
      break;
  }
  return at + "damaged within " + frame + ", expected " + expected_;
}

}  // namespace slipd
