// Recordings of one sensor's frames: a CBOR sequence (RFC 8742), so that a file cut short is whole up to the
// cut, can be appended to without going back, and is read by any CBOR library.
//
//   first item   map: "format" "slipd-recording", "version" 1, "sensor", "class" array3|wrench|normal,
//   "layout"
//                {"grid": [columns, rows], "pitch_m"} or {"x_m": […], "y_m": […]} or {"side_m"} (wrench),
//                "rate_hz", "simulated", "start_realtime_ns", "start_monotonic_ns" (one moment on both
//                clocks), "description", "zeroed" (without it: true)
//   each frame   map of exactly these, in this order: "seq" uint, "time_ns" int (CLOCK_MONOTONIC),
//   "device_time_ns" int or
//                null, "truth_gamma" and "truth_friction" float64 or null, "normal_pa", "shear_x_pa",
//                "shear_y_pa": arrays of float32, little-endian, as RFC 8746 has them (tag 85), one value a
//                taxel in the layout's order. Where it is known what was estimated then (flight recorder), a
//                ninth, "estimate": map of "state" and "alert", uint, in the order of State and Alert of
//                core/estimate/estimate.hpp; "gamma", "sigma", "friction", "normal_n", "shear_n": float64 or
//                null
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/storage/buffered_file.hpp"

namespace slipd {

inline constexpr std::size_t kRecordingMaxTaxels = std::size_t{1} << 20;  // of a grid; scattered: 16384

struct RecordingHeader {
  std::string sensor;
  SensorClass sensor_class = SensorClass::array3;
  TaxelLayout layout;
  double rate_hz = 0;  // 0: unknown
  bool simulated = false;
  std::int64_t start_realtime_ns = 0;
  std::int64_t start_monotonic_ns = 0;
  std::string description;  // for people, of any length up to some thousand characters
  bool zeroed = true;       // its frames read 0 without load
};

// What was estimated from a frame when it was recorded. NaN: not known.
struct RecordedEstimate {
  std::uint8_t state = 0, alert = 0;  // as numbered in core/estimate/estimate.hpp, which stands above this
  double gamma = kUnknown, sigma = kUnknown, friction = kUnknown;
  double normal_n = kUnknown, shear_n = kUnknown;
};

// `FILE: byte N: what is wrong, what was expected`.
class RecordingError : public std::runtime_error {
 public:
  RecordingError(const std::string& what, std::uint64_t offset) : std::runtime_error(what), offset_(offset) {}
  std::uint64_t offset() const noexcept { return offset_; }

 private:
  std::uint64_t offset_;
};

// Writer thread. Frames gather in memory and go to the file when it is full or `flush_after` has passed.
class RecordingWriter {
 public:
  // `fd` stays the caller's and open as long as the writer lives. The header is written with the first
  // frames. Throws std::invalid_argument for a layout too large to record.
  RecordingWriter(int fd, const RecordingHeader& header,
                  std::chrono::milliseconds flush_after = std::chrono::milliseconds(500));
  ~RecordingWriter();  // flushes
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  // Allocates nothing, may wait for the disk. The first error (disk full, pipe closed, a reader that takes
  // nothing for a second) stays: whatever comes later is refused with it. A frame of another size is
  // invalid_argument and leaves no mark.
  // `estimate` may be null: nothing is known of one.
  [[nodiscard]] std::error_code append(const FrameSlot& frame,
                                       const RecordedEstimate* estimate = nullptr) noexcept;
  std::error_code flush() noexcept;
  std::uint64_t bytes() const noexcept {
    return written_ + size_;
  }  // of the file, with what still lies in memory

 private:
  int fd_;
  std::size_t taxels_;
  std::chrono::milliseconds flush_after_;
  std::chrono::steady_clock::time_point flushed_;
  std::vector<std::uint8_t> memory_;
  std::size_t size_ = 0;
  std::uint64_t written_ = 0;
  std::error_code error_;
};

// Streams through a recording of any length in the memory of a few frames. After construction nothing
// allocates or throws, whatever the file holds.
class RecordingReader {
 public:
  enum class Status : std::uint8_t {
    frame,   // `out` is filled
    end,     // the file ended after a whole frame
    damaged  // it did not, or is no recording from here on: fault() says what and where. Everything before
             // was whole.
  };

  // Throws RecordingError for a header that is no recording's, std::system_error for a file that cannot be
  // read.
  explicit RecordingReader(const std::filesystem::path& file);

  const RecordingHeader& header() const noexcept { return header_; }

  // `out`'s spans must have the layout's size; else damaged. end and damaged stay until rewind.
  // `estimate`, if wanted, is what was recorded with the frame.
  Status next(FrameSlot& out, std::optional<RecordedEstimate>* estimate = nullptr) noexcept;
  void rewind() noexcept;  // to the first frame

  std::uint64_t fault_offset() const noexcept { return fault_offset_; }
  std::string fault() const;  // `FILE: byte N: …`; empty without one. Allocates.

 private:
  RecordingHeader read_header();
  Status fail(std::uint64_t offset, const char* expected, bool cut) noexcept;

  std::filesystem::path path_;
  BufferedFile file_;
  std::uint64_t first_frame_ = 0;  // byte offset
  RecordingHeader header_;
  Status status_ = Status::frame;
  std::uint64_t fault_offset_ = 0;
  const char* expected_ = nullptr;
  bool cut_ = false;
};

}  // namespace slipd
