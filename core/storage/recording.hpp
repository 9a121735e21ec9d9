// Recordings of one sensor's frames. A recording is a CBOR sequence (RFC 8742): a file that was cut is whole
// up to the cut, frames are appended without seeking, and any CBOR library reads it.
//
// The first item is a map:
//   "format"              "slipd-recording"
//   "version"             1
//   "sensor"              its name
//   "class"               "array3", "wrench" or "normal"
//   "layout"              {"grid": [columns, rows], "pitch_m"}, {"x_m": […], "y_m": […]} or {"side_m"}
//   "rate_hz"             0: unknown
//   "simulated"           true or false
//   "start_realtime_ns"   start of the recording on CLOCK_REALTIME
//   "start_monotonic_ns"  the same moment on CLOCK_MONOTONIC
//   "description"         of the device, for people
//   "zeroed"              true or false; absent: true
// Each frame is a map of exactly these entries in this order:
//   "seq"                 uint
//   "time_ns"             int, CLOCK_MONOTONIC
//   "device_time_ns"      int or null
//   "truth_gamma"         float64 or null
//   "truth_friction"      float64 or null
//   "normal_pa"           array of little-endian float32 (RFC 8746, tag 85), one value a taxel
//   "shear_x_pa"          the same
//   "shear_y_pa"          the same
//   "estimate"            present if the frame's estimate is known (flight recorder): map of "state" and
//                         "alert" (uint, numbered as State and Alert of core/estimate/estimate.hpp), "gamma",
//                         "sigma", "friction", "normal_n" and "shear_n" (float64 or null)
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

// Most taxels of a grid; a scattered layout has at most 16384.
inline constexpr std::size_t kRecordingMaxTaxels = std::size_t{1} << 20;

// What a recording says once of all its frames.
struct RecordingHeader {
  // The sensor's name in the configuration; at most 4096 bytes are written.
  std::string sensor;
  // What the sensor measures.
  SensorClass sensor_class = SensorClass::array3;
  // Where its taxels are.
  TaxelLayout layout;
  // Frames a second as the device says; 0: unknown.
  double rate_hz = 0;
  // Whether the frames come from a simulation.
  bool simulated = false;
  // Start of the recording, ns, CLOCK_REALTIME.
  std::int64_t start_realtime_ns = 0;
  // The same moment, ns, CLOCK_MONOTONIC.
  std::int64_t start_monotonic_ns = 0;
  // The device, for people; at most 4096 bytes are written.
  std::string description;
  // Whether frames read 0 without load.
  bool zeroed = true;
};

// What was estimated from a frame when it was recorded. Unknown numbers are NaN.
struct RecordedEstimate {
  // State of core/estimate/estimate.hpp, as a number: this room does not include estimate.
  std::uint8_t state = 0;
  // Alert of core/estimate/estimate.hpp, as a number.
  std::uint8_t alert = 0;
  // Safety margin, 0 to 1.
  double gamma = kUnknown;
  // Standard deviation of gamma.
  double sigma = kUnknown;
  // Friction coefficient.
  double friction = kUnknown;
  // Normal force, N.
  double normal_n = kUnknown;
  // Tangential force, N.
  double shear_n = kUnknown;
};

// what() is `FILE: byte N: what is wrong, what was expected`.
class RecordingError : public std::runtime_error {
 public:
  RecordingError(const std::string& what, std::uint64_t offset) : std::runtime_error(what), offset_(offset) {}
  // Position of the fault in the file, bytes.
  std::uint64_t offset() const noexcept { return offset_; }

 private:
  std::uint64_t offset_;
};

// Writes a recording. Frames are buffered and written when the buffer is full or `flush_after` has passed.
// Not thread-safe. Called from one thread: the recording's writer.
class RecordingWriter {
 public:
  // The caller owns `fd` and keeps it open while the writer lives. The header is written with the first
  // frames. Throws std::invalid_argument for a layout that is too large to record.
  RecordingWriter(int fd, const RecordingHeader& header,
                  std::chrono::milliseconds flush_after = std::chrono::milliseconds(500));
  // Flushes; an error is ignored.
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  // Appends a frame and its estimate; null: the estimate is not known. Allocates nothing, may wait for the
  // disk. The first error (disk full, pipe closed, a pipe whose reader takes nothing for a second) is
  // permanent: every later call returns it. A frame of another size returns invalid_argument, which is not
  // permanent.
  [[nodiscard]] std::error_code append(const FrameSlot& frame,
                                       const RecordedEstimate* estimate = nullptr) noexcept;
  // Writes what is buffered. May wait for the disk.
  std::error_code flush() noexcept;
  // Size of the recording, bytes, with what is still buffered.
  std::uint64_t bytes() const noexcept { return written_ + size_; }

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

// Reads a recording of any length in the memory of a few frames. After construction nothing but fault()
// allocates, and nothing throws, whatever the file holds. Not thread-safe: one thread at a time.
class RecordingReader {
 public:
  enum class Status : std::uint8_t {
    frame,   // `out` is filled
    end,     // the file ended after a whole frame
    damaged  // the file ended within a frame or is no recording from here on; see fault(). All frames before
             // were whole.
  };

  // Reads the header. Throws RecordingError if it is not a recording's, std::system_error if the file cannot
  // be read.
  explicit RecordingReader(const std::filesystem::path& file);

  const RecordingHeader& header() const noexcept { return header_; }

  // Reads the next frame. The spans of `out` must have the layout's size, else the result is damaged. end and
  // damaged stay until rewind. `estimate` may be null; else it gets the frame's estimate, or nothing if none
  // was recorded.
  Status next(FrameSlot& out, std::optional<RecordedEstimate>* estimate = nullptr) noexcept;
  // Returns to the first frame.
  void rewind() noexcept;

  // Position of the damage, bytes; 0 without damage.
  std::uint64_t fault_offset() const noexcept { return fault_offset_; }
  // `FILE: byte N: …`; empty without damage. Allocates.
  std::string fault() const;

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
