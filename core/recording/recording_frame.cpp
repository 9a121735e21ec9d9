#include "core/recording/recording_frame.hpp"

namespace slipd {
namespace {

constexpr std::uint64_t kEntries = 8;  // of a frame without estimate

constexpr std::size_t most_estimate_bytes() {
  constexpr std::size_t kHead = 9;  // of CBOR, at most; a number takes as many
  std::size_t bytes = 0;
  for (const RecordedEntry& entry : kRecordedEntries) bytes += kHead + entry.key.size() + kHead;
  return bytes;
}
// Bytes of a frame beside its taxels' values and the estimate's entries; it takes less.
constexpr std::size_t kMostBesides = 256;

void put_estimate(cbor::Writer& out, const RecordedEstimate& estimate) noexcept {
  out.text("estimate");
  out.map(kRecordedEntries.size());
  for (const RecordedEntry& entry : kRecordedEntries) {
    out.text(entry.key);
    if (entry.number != nullptr) {
      out.float64_or_null(estimate.*entry.number);
    } else if (estimate.*entry.code == RecordedEstimate::kNoCode) {
      out.null();
    } else {
      out.unsigned_integer(estimate.*entry.code);
    }
  }
}

// A code that is none of this or a newer slipd is unknown.
std::uint8_t code_of(std::optional<std::int64_t> number) noexcept {
  return number && *number >= 0 && *number < RecordedEstimate::kNoCode ? static_cast<std::uint8_t>(*number)
                                                                       : RecordedEstimate::kNoCode;
}

// False: the estimate's map has too few entries.
bool take_estimate(cbor::Reader& in, RecordedEstimate& estimate) noexcept {
  in.text("estimate");
  const std::uint64_t entries = in.map();
  if (in.ok() && entries < kFewestRecordedEntries) return false;
  for (std::uint64_t i = 0; i < entries && in.ok(); ++i) {
    if (i >= kRecordedEntries.size()) {
      in.skip();
      in.skip();
      continue;
    }
    const RecordedEntry& entry = kRecordedEntries[i];
    in.text(entry.key);
    if (entry.number != nullptr) {
      estimate.*entry.number = in.float64_or_null();
    } else {
      estimate.*entry.code = code_of(in.integer_or_null());
    }
  }
  return true;
}

}  // namespace

std::size_t largest_frame_bytes(std::size_t taxels) noexcept {
  return kMostBesides + most_estimate_bytes() + 3 * taxels * sizeof(float);
}

void put_frame(cbor::Writer& out, const FrameSlot& frame, const RecordedEstimate* estimate) noexcept {
  out.map(estimate != nullptr ? kEntries + 1 : kEntries);
  out.text("seq");
  out.unsigned_integer(frame.sequence);
  out.text("time_ns");
  out.integer(frame.time_ns);
  out.text("device_time_ns");
  if (frame.device_time_ns < 0) {
    out.null();
  } else {
    out.integer(frame.device_time_ns);
  }
  out.text("truth_gamma");
  out.float64_or_null(frame.truth.gamma);
  out.text("truth_friction");
  out.float64_or_null(frame.truth.friction);
  out.text("normal_pa");
  out.float32_array(frame.normal_pa);
  out.text("shear_x_pa");
  out.float32_array(frame.shear_x_pa);
  out.text("shear_y_pa");
  out.float32_array(frame.shear_y_pa);
  if (estimate != nullptr) put_estimate(out, *estimate);
}

const char* take_frame(cbor::Reader& in, FrameSlot& out, std::optional<RecordedEstimate>* estimate) noexcept {
  const std::uint64_t entries = in.map();
  if (in.ok() && entries != kEntries && entries != kEntries + 1)
    return "a map of 8 entries, a frame, or 9 with an estimate";
  in.text("seq");
  out.sequence = in.unsigned_integer();
  in.text("time_ns");
  out.time_ns = in.integer();
  in.text("device_time_ns");
  out.device_time_ns = in.integer_or_null().value_or(-1);
  in.text("truth_gamma");
  out.truth.gamma = in.float64_or_null();
  in.text("truth_friction");
  out.truth.friction = in.float64_or_null();
  in.text("normal_pa");
  in.float32_array(out.normal_pa);
  in.text("shear_x_pa");
  in.float32_array(out.shear_x_pa);
  in.text("shear_y_pa");
  in.float32_array(out.shear_y_pa);
  if (RecordedEstimate recorded; entries == kEntries + 1) {
    if (!take_estimate(in, recorded)) return "an estimate";
    if (estimate != nullptr) *estimate = recorded;
  }
  return in.fault();
}

}  // namespace slipd
