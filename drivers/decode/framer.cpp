#include "drivers/decode/framer.hpp"

#include <algorithm>

#include "drivers/decode/checksum.hpp"
#include "drivers/decode/csv_line.hpp"
#include "drivers/decode/pts2.hpp"
#include "wire/number.hpp"

namespace slipd::decode {
namespace {

constexpr std::size_t kLongestPiece = 65536;  // bytes of one put(), on any bus
constexpr std::size_t kTooLong = SIZE_MAX;

}  // namespace

Framer::Framer(const Profile& profile)
    : stream_(profile.stream.value_or(Stream{})),
      framed_(profile.stream.has_value()),
      sensors_(profile.sensors),
      pillars_(profile.layout.size()),
      capacity_(kLongestPiece),
      buffer_(capacity_ + stream_.longest),
      flat_(stream_.pts2 ? kPts2Head + sensors_ * pillars_ * kPts2Pillar
                         : stream_.csv_values * sizeof(double)) {
  checksum_of(stream_.checksum.kind, {});  // computes its table
  reset();
}

void Framer::reset() noexcept {
  used_ = filled_ = searched_ = unreported_garbage_ = 0;
  records_ = {};
  in_garbage_ = true;
  between_frames_ = !stream_.begin.empty() || stream_.length != 0;
}

void Framer::put(Bytes bytes) noexcept {
  std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(used_),
            buffer_.begin() + static_cast<std::ptrdiff_t>(filled_), buffer_.begin());
  filled_ -= used_;
  used_ = 0;
  const std::size_t taken = std::min(bytes.size(), buffer_.size() - filled_);
  std::copy_n(bytes.begin(), taken, buffer_.begin() + static_cast<std::ptrdiff_t>(filled_));
  filled_ += taken;
}

// The number of bytes before a marker (`found` true) or before the beginning of a possible one.
std::size_t Framer::before(Bytes marker, bool& found) const noexcept {
  const Bytes all = held();
  const auto at = std::search(all.begin(), all.end(), marker.begin(), marker.end());
  found = at != all.end();
  if (found) return static_cast<std::size_t>(at - all.begin());
  std::size_t keep = std::min(all.size(), marker.size() - 1);
  while (!std::equal(all.end() - static_cast<std::ptrdiff_t>(keep), all.end(), marker.begin())) --keep;
  return all.size() - keep;
}

// Discards bytes as garbage. True where that is to be reported: when a run of garbage begins, and again after
// more bytes than the longest frame has.
bool Framer::lose(std::size_t bytes) noexcept {
  counts_.garbage += bytes;
  used_ += bytes;
  searched_ = 0;
  unreported_garbage_ += bytes;
  if (in_garbage_ && unreported_garbage_ <= stream_.longest) return false;
  in_garbage_ = true;
  unreported_garbage_ = 0;
  ++counts_.invalid;
  return true;
}

// The size of the frame at the beginning of the bytes; 0: more bytes are needed.
std::size_t Framer::size_of(Bytes bytes) const noexcept {
  if (stream_.length != 0) return stream_.length;
  if (stream_.length_byte.plus != 0) {
    if (bytes.size() <= stream_.length_byte.offset) return 0;
    const std::size_t size = bytes[stream_.length_byte.offset] + stream_.length_byte.plus;
    return size > stream_.longest ? kTooLong : size;
  }
  const auto from = bytes.begin() + static_cast<std::ptrdiff_t>(std::max(stream_.begin.size(), searched_));
  const auto found = from < bytes.end()
                         ? std::search(from, bytes.end(), stream_.end.begin(), stream_.end.end())
                         : bytes.end();
  if (found == bytes.end()) return bytes.size() > stream_.longest ? kTooLong : 0;
  const auto size = static_cast<std::size_t>(found - bytes.begin()) + stream_.end.size();
  return size > stream_.longest ? kTooLong : size;
}

bool Framer::is_right(Bytes frame) const noexcept {
  const auto end_marker = static_cast<std::ptrdiff_t>(stream_.end.size());
  if (frame.size() < stream_.begin.size() + stream_.end.size()) return false;
  if (!std::equal(stream_.end.begin(), stream_.end.end(), frame.end() - end_marker)) return false;
  const Checksum& sum = stream_.checksum;
  if (sum.kind == ChecksumKind::none) return true;
  const auto place = place_of(sum, frame.size());
  if (!place) return false;
  return wire::read_bits(frame.data() + place->at, bytes_of(sum.kind), is_big_endian(sum.kind)) ==
         checksum_of(sum.kind, frame.subspan(place->from, place->to - place->from));
}

Framer::Result Framer::next_record(RawPacket& out) noexcept {
  for (const Record& record : stream_.records) {
    if ((records_.front() & record.mask) != record.tag || records_.size() <= record.bytes) continue;
    out = {records_.front(), records_.subspan(1, record.bytes)};
    records_ = records_.subspan(1 + record.bytes);
    return Result::packet;
  }
  records_ = {};
  ++counts_.invalid;
  return Result::invalid;
}

Framer::Result Framer::unpack(Bytes frame, RawPacket& out) noexcept {
  if (stream_.pts2) {
    const std::size_t head = stream_.begin.size();
    const std::size_t around = head + stream_.end.size() + bytes_of(stream_.checksum.kind);
    if (frame.size() < around ||
        !flatten_pts2(frame.subspan(head, frame.size() - around), sensors_, pillars_, flat_)) {
      ++counts_.invalid;
      return Result::invalid;
    }
    out = {0, flat_};
    return Result::packet;
  }
  if (stream_.csv_values != 0) {
    const std::size_t around = stream_.begin.size() + stream_.end.size();
    if (!numbers_of_line(frame.subspan(stream_.begin.size(), frame.size() - around), flat_)) {
      ++counts_.invalid;
      return Result::invalid;
    }
    out = {0, flat_};
    return Result::packet;
  }
  if (!stream_.records.empty()) {
    if (frame.size() <= stream_.records_from) return Result::incomplete;  // a frame without records
    records_ = frame.subspan(stream_.records_from);
    return next_record(out);
  }
  out = {0, frame};
  return Result::packet;
}

Framer::Result Framer::next(RawPacket& out) noexcept {
  if (!records_.empty()) return next_record(out);
  if (!framed_) {
    if (used_ == filled_) return Result::incomplete;
    out = {0, held()};
    used_ = filled_;
    ++counts_.frames;
    return Result::packet;
  }
  if (!between_frames_) {
    const std::size_t rest = before(stream_.end, between_frames_);
    if (lose(rest + (between_frames_ ? stream_.end.size() : 0))) return Result::invalid;
    if (!between_frames_) return Result::incomplete;
  }
  for (;;) {
    bool begun = false;
    const std::size_t garbage = before(stream_.begin, begun);
    if (garbage > 0 && lose(garbage)) return Result::invalid;
    if (!begun) return Result::incomplete;
    const std::size_t size = size_of(held());
    if (size != kTooLong && (size == 0 || held().size() < size)) {
      const std::size_t overlap = stream_.end.empty() ? 0 : stream_.end.size() - 1;
      searched_ = held().size() > overlap ? held().size() - overlap : 0;
      return Result::incomplete;
    }
    if (size == kTooLong || !is_right(held().first(size))) {
      if (lose(1)) return Result::invalid;
      continue;
    }
    const Bytes frame = held().first(size);
    used_ += size;
    searched_ = unreported_garbage_ = 0;
    in_garbage_ = false;
    ++counts_.frames;
    const Result got = unpack(frame, out);
    if (got != Result::incomplete) return got;
  }
}

}  // namespace slipd::decode
