#include "core/storage/recording.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "core/storage/cbor.hpp"
#include "core/storage/recording_header.hpp"

namespace slipd {
namespace {

constexpr std::size_t kGather = std::size_t{1} << 20;
constexpr std::size_t kFirstLook = std::size_t{1} << 14;
constexpr std::uint64_t kEntries = 8;  // of a frame without estimate
constexpr std::uint64_t kEstimateEntries = 7;
constexpr int kPatienceMs = 1000;

// Bytes of a frame at most. Everything but the taxels' values takes less than 350 bytes.
std::size_t largest_frame(std::size_t taxels) {
  return 384 + 3 * taxels * sizeof(float);
}

// Calls `body` with the name and the value of each number. Writing and reading use the same list.
template <typename Estimate, typename Body>
void for_each_number(Estimate& estimate, Body body) {
  body("gamma", estimate.gamma);
  body("sigma", estimate.sigma);
  body("friction", estimate.friction);
  body("normal_n", estimate.normal_n);
  body("shear_n", estimate.shear_n);
}

void put_estimate(cbor::Writer& out, const RecordedEstimate& estimate) noexcept {
  out.text("estimate");
  out.map(kEstimateEntries);
  out.text("state");
  out.unsigned_integer(estimate.state);
  out.text("alert");
  out.unsigned_integer(estimate.alert);
  for_each_number(estimate, [&out](const char* name, double value) {
    out.text(name);
    out.float64_or_null(value);
  });
}

// False: the estimate's map has another number of entries.
bool take_estimate(cbor::Reader& in, RecordedEstimate& estimate) noexcept {
  in.text("estimate");
  if (in.map() != kEstimateEntries && in.ok()) return false;
  in.text("state");
  estimate.state = static_cast<std::uint8_t>(in.unsigned_integer());
  in.text("alert");
  estimate.alert = static_cast<std::uint8_t>(in.unsigned_integer());
  for_each_number(estimate, [&in](const char* name, double& value) {
    in.text(name);
    value = in.float64_or_null();
  });
  return true;
}

std::error_code write_all(int fd, const std::uint8_t* bytes, std::size_t size) noexcept {
  while (size > 0) {
    const auto done = ::write(fd, bytes, size);
    if (done >= 0) {
      bytes += done;
      size -= static_cast<std::size_t>(done);
    } else if (errno == EAGAIN) {
      pollfd wait{fd, POLLOUT, 0};
      if (::poll(&wait, 1, kPatienceMs) == 0) return std::make_error_code(std::errc::timed_out);
    } else if (errno != EINTR) {
      return {errno, std::generic_category()};
    }
  }
  return {};
}

}  // namespace

RecordingWriter::RecordingWriter(int fd, const RecordingHeader& header, std::chrono::milliseconds flush_after)
    : fd_(fd),
      taxels_(header.layout.size()),
      flush_after_(flush_after),
      flushed_(std::chrono::steady_clock::now()) {
  const auto bytes = encode_header(header);
  memory_.resize(std::max(kGather, bytes.size() + largest_frame(taxels_)));
  std::copy(bytes.begin(), bytes.end(), memory_.begin());
  size_ = bytes.size();
}

RecordingWriter::~RecordingWriter() {
  flush();
}

std::error_code RecordingWriter::append(const FrameSlot& frame, const RecordedEstimate* estimate) noexcept {
  if (frame.normal_pa.size() != taxels_ || frame.shear_x_pa.size() != taxels_ ||
      frame.shear_y_pa.size() != taxels_) {
    return std::make_error_code(std::errc::invalid_argument);
  }
  if (memory_.size() - size_ < largest_frame(taxels_)) flush();
  if (error_) return error_;
  cbor::Writer out(memory_.data() + size_);
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
  size_ = static_cast<std::size_t>(out.at() - memory_.data());
  if (std::chrono::steady_clock::now() - flushed_ >= flush_after_) flush();
  return error_;
}

std::error_code RecordingWriter::flush() noexcept {
  if (!error_) error_ = write_all(fd_, memory_.data(), size_);
  if (!error_) written_ += size_;
  size_ = 0;
  flushed_ = std::chrono::steady_clock::now();
  return error_;
}

RecordingReader::RecordingReader(const std::filesystem::path& file)
    : path_(file), file_(file, kFirstLook), header_(read_header()) {
  file_.reserve(2 * largest_frame(header_.layout.size()));
}

RecordingHeader RecordingReader::read_header() {
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
    auto header = decode_header(bytes.first(item.position()));
    file_.consume(item.position());
    return header;
  } catch (const std::invalid_argument& e) {
    throw refuse(0, e.what());
  }
}

RecordingReader::Status RecordingReader::fail(std::uint64_t offset, const char* expected, bool cut) noexcept {
  fault_offset_ = offset;
  expected_ = expected;
  cut_ = cut;
  return status_ = Status::damaged;
}

RecordingReader::Status RecordingReader::next(FrameSlot& out,
                                              std::optional<RecordedEstimate>* estimate) noexcept {
  if (estimate != nullptr) estimate->reset();
  if (status_ != Status::frame) return status_;
  const std::size_t taxels = header_.layout.size();
  if (out.normal_pa.size() != taxels || out.shear_x_pa.size() != taxels || out.shear_y_pa.size() != taxels) {
    return fail(file_.offset(), "a slot of the layout's size to read into", false);
  }
  const auto bytes = file_.peek(largest_frame(taxels));
  if (file_.error() != 0) return fail(file_.offset() + bytes.size(), "to be able to read on", false);
  if (bytes.empty()) return status_ = Status::end;

  cbor::Reader in(bytes);
  const std::uint64_t entries = in.map();
  if (in.ok() && entries != kEntries && entries != kEntries + 1)
    return fail(file_.offset(), "a map of 8 entries, a frame, or 9 with an estimate", false);
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
    if (!take_estimate(in, recorded)) return fail(file_.offset() + in.position(), "an estimate", false);
    if (estimate != nullptr) *estimate = recorded;
  }
  if (!in.ok())
    return fail(file_.offset() + (in.starved() ? bytes.size() : in.position()), in.fault(), in.starved());
  file_.consume(in.position());
  return status_;
}

void RecordingReader::rewind() noexcept {
  file_.rewind();
  file_.peek(static_cast<std::size_t>(first_frame_));
  file_.consume(static_cast<std::size_t>(first_frame_));
  status_ = Status::frame;
  expected_ = nullptr;
}

std::string RecordingReader::fault() const {
  if (expected_ == nullptr) return {};
  const std::string at = path_.string() + ": byte " + std::to_string(fault_offset_) + ": ";
  if (file_.error() != 0) return at + std::generic_category().message(file_.error());
  if (cut_)
    return at + "the recording ends within the frame that begins at byte " + std::to_string(file_.offset());
  return at + "damaged within the frame that begins at byte " + std::to_string(file_.offset()) +
         ", expected " + expected_;
}

}  // namespace slipd
