// Recordings of one sensor's frames. A recording is a CBOR sequence (RFC 8742): any CBOR library reads it.
// Frames are in blocks, each with a checksum, so that a damage costs its block and nothing else: no frame
// comes back other than it was written. A recording that was cut is whole up to its last whole block.
//
// The first item is the header, a map:
//   "format"   "slipd-recording"
//   "version"  2
//   "crc64"    CRC-64/XZ of "body"
//   "body"     byte string, which holds a map:
//     "sensor"              its name
//     "class"               "array3", "wrench" or "normal"
//     "layout"              {"grid": [columns, rows], "pitch_m"}, {"x_m": […], "y_m": […]} or {"side_m"}
//     "rate_hz"             0: unknown
//     "simulated"           true or false
//     "start_realtime_ns"   start of the recording on CLOCK_REALTIME
//     "start_monotonic_ns"  the same moment on CLOCK_MONOTONIC
//     "description"         of the device, for people
//     "zeroed"              true or false; absent: true
// Each block is a map of exactly these entries in this order. Integers have 8 bytes after their first one,
// the byte string's length has 4, so that a block begins with the bytes A8 65 62 6C 6F 63 6B 1B:
//   "block"     its number, from 0
//   "of"        XXH3-64 of the header's bytes, which tells this recording's blocks from others
//   "frames"    frames in it
//   "before"    frames in all blocks before it
//   "first_ns"  "time_ns" of its first frame
//   "last_ns"   "time_ns" of its last frame
//   "body"      byte string: its frames, one after another
//   "xxh3"      XXH3-64 of all bytes of the block before this entry
// Each frame is a map of exactly these entries in this order:
//   "seq"                 uint
//   "time_ns"             int, CLOCK_MONOTONIC
//   "device_time_ns"      int or null
//   "truth_gamma"         float64 or null
//   "truth_friction"      float64 or null
//   "normal_pa"           array of little-endian float32 (RFC 8746, tag 85), one value a taxel
//   "shear_x_pa"          the same
//   "shear_y_pa"          the same
//   "estimate"            present if the frame's estimate is known (flight recorder): map of the entries of
//                         recorded_estimate.hpp in this order: "state" and "alert" (uint), "gamma", "sigma",
//                         "friction", "normal_n" and "shear_n" (float64 or null); absent in older recordings
//                         "sliding" and "alert_cause" (uint or null); "torque_nm" and "turned_rad"
//                         (float64 or null); "gamma_low", "friction_sigma", "shear_x_n", "shear_y_n",
//                         "torque_sigma_nm", "turned_sigma_rad", "center_x_m", "center_y_m", "radius_m",
//                         "a_over_r", "time_to_slip_s", "grip_increase_n", "grip_increase_sigma_n" and
//                         "sliding_for_s" (float64 or null), "method" and "health" (uint or null). Numbers
//                         of names are those of State, Alert, AlertCause and Method of
//                         core/estimate/estimate.hpp, Sliding of core/sliding/sliding.hpp and Health of
//                         core/health/health.hpp. Further entries are of a newer slipd, and passed over
// The last item of a recording that was finished is the index, a map of these entries in this order, with
// widths as above:
//   "index"     byte string: of some blocks, the first one among them, position in the file and "first_ns",
//               each 8 bytes, little-endian
//   "of"        as in blocks
//   "blocks"    number of blocks
//   "frames"    number of frames
//   "header"    byte string: a copy of the header
//   "xxh3"      XXH3-64 of all bytes of the index before this entry
//   "index_at"  position of the index in the file; the last 18 bytes of the file are this entry
//
// Version 1, which is still read, has no blocks, no checksums and no index: its header is the map of the
// header's body with "format" and "version", and the frames follow it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/recording/recorded_estimate.hpp"
#include "core/recording/recording_block.hpp"
#include "core/storage/bounded_output.hpp"
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

// what() is `FILE: byte N: what is wrong, what was expected`.
class RecordingError : public std::runtime_error {
 public:
  RecordingError(const std::string& what, std::uint64_t offset) : std::runtime_error(what), offset_(offset) {}
  // Position of the fault in the file, bytes.
  std::uint64_t offset() const noexcept { return offset_; }

 private:
  std::uint64_t offset_;
};

// Time between two writes of a recording, unless its buffer is full before.
inline constexpr std::chrono::milliseconds kRecordingFlush{500};

// Writes a recording. Frames are buffered and written when the buffer is full or `flush_after` has passed.
// Not thread-safe. Called from one thread: the recording's writer.
class RecordingWriter {
 public:
  // The caller owns `fd` and keeps it open while the writer lives. `patience`: `fd` is a socket, whose reader
  // is waited for so long; none: it is a file. The header is written with the first frames. Throws
  // std::invalid_argument for a layout that is too large to record.
  RecordingWriter(int fd, const RecordingHeader& header,
                  std::chrono::milliseconds flush_after = kRecordingFlush,
                  std::optional<OutputPatience> patience = std::nullopt);
  // Finishes; an error is ignored.
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  // Appends a frame and its estimate; null: the estimate is not known. Allocates nothing, may wait for the
  // disk. The first error (disk full, socket closed, a reader that takes nothing for longer than
  // `patience`) is permanent: every later call returns it. A frame of another size returns invalid_argument,
  // which is not permanent.
  [[nodiscard]] std::error_code append(const FrameSlot& frame,
                                       const RecordedEstimate* estimate = nullptr) noexcept;
  // Ends the present block and writes what is buffered. May wait for the disk.
  std::error_code flush() noexcept;
  // Flushes and writes the index. Nothing can be appended any more.
  std::error_code finish() noexcept;
  // Size of the recording, bytes, with what is still buffered.
  std::uint64_t bytes() const noexcept { return written_ + size_; }

 private:
  void begin_block() noexcept;
  void end_block() noexcept;
  void add_to_index(const IndexEntry& entry) noexcept;
  void write_out() noexcept;
  std::error_code put(std::span<const std::uint8_t> bytes) const noexcept;
  int fd_;
  std::optional<OutputPatience> patience_;
  std::size_t taxels_;
  std::chrono::milliseconds flush_after_;
  std::chrono::steady_clock::time_point flushed_;
  std::vector<std::uint8_t> memory_;
  std::size_t size_ = 0;         // bytes in memory_
  std::size_t block_begin_ = 0;  // of the present block in memory_
  BlockHead block_;              // the present block, as far as it is written; frames 0: there is none
  RecordingIndex index_;
  std::uint64_t index_step_ = 1;  // blocks from one entry of the index to the next
  std::uint64_t written_ = 0;
  std::error_code error_;
  bool finished_ = false;
};

// Reads a recording of any length in the memory of a few blocks. After construction nothing but fault()
// allocates, and nothing throws, whatever the file holds. Not thread-safe: one thread at a time.
class RecordingReader {
 public:
  enum class Status : std::uint8_t {
    frame,      // `out` is filled
    skipped,    // a damaged block was passed over; there may be more frames
    searching,  // nothing yet; there may be more frames. Limits what one call reads
    end,        // there is no more; fault() is empty unless something was damaged or cut
    damaged     // the file cannot be read on, or is of version 1 and damaged or cut; see fault()
  };

  // Reads the header, and the index if there is one; if the header is damaged, its copy in the index. Throws
  // RecordingError if it is not a recording's, std::system_error if the file cannot be read.
  explicit RecordingReader(const std::filesystem::path& file);

  const RecordingHeader& header() const noexcept { return header_; }

  // Reads the next frame. The spans of `out` must have the layout's size, else the result is damaged. end and
  // damaged stay until rewind or seek. `estimate` may be null; else it gets the frame's estimate, or nothing
  // if none was recorded. What is not a frame leaves `out` undefined.
  Status next(FrameSlot& out, std::optional<RecordedEstimate>* estimate = nullptr) noexcept;
  // As next, for readers that may wait: passes over skipped and searching.
  Status next_frame(FrameSlot& out, std::optional<RecordedEstimate>* estimate = nullptr) noexcept;
  // Returns to the first frame and forgets damages.
  void rewind() noexcept;
  // Continues at the first frame from `time_ns` (CLOCK_MONOTONIC) on, and forgets damages. False, without
  // effect: the recording has no index.
  bool seek(std::int64_t time_ns) noexcept;

  // Number of frames that were recorded; none: the recording has no index.
  std::optional<std::uint64_t> frames() const noexcept;
  // Damaged blocks passed over so far.
  std::uint64_t damaged_blocks() const noexcept { return damaged_blocks_; }
  // Position of the first damage, bytes; 0 without damage.
  std::uint64_t fault_offset() const noexcept { return fault_offset_; }
  // Whether anything was damaged or cut so far.
  bool has_fault() const noexcept { return trouble_ != Trouble::none; }
  // `FILE: byte N: …`; empty if nothing was damaged or cut so far. Allocates.
  std::string fault() const;

 private:
  // What is wrong first, for fault().
  enum class Trouble : std::uint8_t { none, damaged, cut_within, unfinished, unreadable, v1_damaged, v1_cut };

  RecordingHeader read_header();
  RecordingHeader header_at_start();
  std::optional<RecordingHeader> header_of_index();
  void load_index();
  void start_at(std::uint64_t offset) noexcept;
  Status next_of_sequence(FrameSlot& out, std::optional<RecordedEstimate>* estimate) noexcept;
  Status next_of_blocks(FrameSlot& out, std::optional<RecordedEstimate>* estimate) noexcept;
  Status take_frame_of_block(FrameSlot& out, std::optional<RecordedEstimate>* estimate) noexcept;
  Status take_item() noexcept;
  Status search() noexcept;
  bool take_whole_item(std::span<const std::uint8_t> bytes) noexcept;
  void count_damaged(std::uint64_t blocks, std::uint64_t frames) noexcept;
  void end_of_file() noexcept;
  void note(Trouble trouble, std::uint64_t offset) noexcept;
  Status fail(Trouble trouble, std::uint64_t offset, const char* expected) noexcept;

  std::filesystem::path path_;
  BufferedFile file_;
  int version_ = 2;
  std::optional<RecordingIndex> index_;
  bool header_damaged_ = false;
  std::uint64_t of_ = 0;           // BlockHead::of of this recording's blocks
  std::uint64_t first_frame_ = 0;  // byte offset of the first frame, or of the first block
  RecordingHeader header_;
  std::size_t item_bytes_ = 0;  // of the largest block or index

  // Where reading is.
  Status status_ = Status::frame;     // end and damaged stay
  std::uint64_t next_number_ = 0;     // of the next block
  bool any_number_ = false;           // after seek: the next block may have any number
  std::int64_t from_ns_ = INT64_MIN;  // frames before are passed over
  std::uint64_t frames_before_ = 0;   // in the blocks up to the present one
  std::uint64_t frames_left_ = 0;     // in the present block
  std::size_t body_left_ = 0;         // bytes of the present block's frames
  bool searching_ = false;
  std::size_t search_from_ = 0;  // in the buffer
  std::uint64_t skips_due_ = 0;  // damaged blocks that were not returned yet

  // What was wrong.
  std::uint64_t damaged_blocks_ = 0, damaged_frames_ = 0;
  Trouble trouble_ = Trouble::none;
  std::uint64_t fault_offset_ = 0;
  const char* expected_ = nullptr;
};

}  // namespace slipd
