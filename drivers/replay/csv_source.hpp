// CSV as a source of frames: one line of column names, then a line per frame with txl1_x, txl1_y, txl1_z …
// txlN_z in any order, N the layout's size, optionally `time` in s; other columns are ignored. The option
// `taxels` names other columns. Without `time`, rows are spaced by the sensor's rate_hz, and a column such as
// `timestamp` is refused. A row with a missing value (empty, NA, nan, inf) is
// corrupt; the next one is read on. Lines are read and numbers parsed in place: no allocation after
// construction.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/storage/buffered_file.hpp"
#include "drivers/replay/source.hpp"

namespace slipd::replay {

class CsvSource final : public FrameSource {
 public:
  // Throws DriverError as open_source says.
  CsvSource(const std::filesystem::path& file, const SensorSetup& sensor);

  ReadOutcome next(FrameSlot& out) noexcept override;
  void rewind() noexcept override;
  bool has_fault() const noexcept override { return fault_ != nullptr; }
  std::string fault() const override;  // `FILE: line L, column C (name): …`
  double rate_hz() const noexcept override { return rate_hz_; }
  SensorClass sensor_class() const noexcept override { return class_; }
  bool zeroed() const noexcept override { return zeroed_; }  // by `bias`, unless `unit` is raw

 private:
  enum class Channel : std::uint8_t { ignored, time, x, y, z };
  struct Column {
    std::string name;
    Channel channel = Channel::ignored;
    std::size_t taxel = 0;
  };
  enum class Line : std::uint8_t { whole, end, failed };

  Line next_line(std::string_view& line) noexcept;
  void read_header(const SensorSetup& sensor);
  Column column_of(std::string_view name, const SensorSetup& sensor) const;
  void refuse_beyond_layout(std::string_view column, const SensorSetup& sensor) const;
  void refuse_time_of_another_name() const;
  // False: the field is no number. `complete` becomes false where the value is missing.
  bool store(const Column& column, std::string_view field, FrameSlot& out, bool& complete) const noexcept;
  ReadOutcome fail(std::size_t column, const char* what, std::string_view field) noexcept;

  std::filesystem::path path_;
  BufferedFile file_;
  std::size_t taxels_;
  std::vector<std::string> names_;  // of the taxels, in the layout's order
  double rate_hz_;
  SensorClass class_;
  bool zeroed_;
  std::vector<Column> columns_;
  bool has_time_ = false;
  std::uint64_t line_ = 0;        // number of the line that was read last, from 1
  std::uint64_t row_ = 0;         // frames returned
  std::size_t fault_column_ = 0;  // column of the fault, from 1; 0: the whole line
  const char* fault_ = nullptr;   // null: none so far
  std::array<char, 24> field_{};  // the beginning of the faulty field
};

}  // namespace slipd::replay
