#include "drivers/replay/csv_source.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <system_error>

#include "drivers/replay/options.hpp"

namespace slipd::replay {
namespace {

constexpr std::size_t kBytesPerNumber = 32;
constexpr std::size_t kLongestLine = std::size_t{1} << 16;  // bytes
constexpr std::size_t kMostBlankBytes = std::size_t{1}
                                        << 16;  // of empty lines in a row; limits what one read takes
constexpr double kLatestSeconds = 9e9;          // 64 bits hold so many seconds in nanoseconds

std::string_view trimmed(std::string_view s) noexcept {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!s.empty() && blank(s.front())) s.remove_prefix(1);
  while (!s.empty() && blank(s.back())) s.remove_suffix(1);
  return s;
}

// Cuts the first field off `rest`; false when none is left, which is when rest.data() is null.
bool next_field(std::string_view& rest, std::string_view& field) noexcept {
  if (rest.data() == nullptr) return false;
  const auto comma = rest.find(',');
  field = trimmed(rest.substr(0, comma));
  rest = comma == std::string_view::npos ? std::string_view() : rest.substr(comma + 1);
  return true;
}

// NaN for what tables write where a value is missing: nothing, NA, nan. False: no number.
bool parse(std::string_view field, double& value) noexcept {
  if (field.empty() || field == "NA") {
    value = std::numeric_limits<double>::quiet_NaN();
    return true;
  }
  if (field.front() == '+') field.remove_prefix(1);
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error == std::errc() && end == field.data() + field.size();
}

BufferedFile open_file(const std::filesystem::path& file, std::size_t taxels) {
  try {
    return {file, kLongestLine + 3 * kBytesPerNumber * taxels};
  } catch (const std::system_error& e) {
    throw DriverError(e.what());
  }
}

}  // namespace

CsvSource::CsvSource(const std::filesystem::path& file, const SensorSetup& sensor)
    : path_(file),
      file_(open_file(file, sensor.layout.size())),
      taxels_(sensor.layout.size()),
      names_(taxel_names(sensor)),
      rate_hz_(sensor.rate_hz),
      class_(taxels_ == 1 ? SensorClass::wrench : SensorClass::array3),
      zeroed_(sensor.options.value("unit", "Pa") != "raw") {
  read_header(sensor);
}

CsvSource::Line CsvSource::next_line(std::string_view& line) noexcept {
  auto bytes = file_.peek(1);
  const void* newline = bytes.empty() ? nullptr : std::memchr(bytes.data(), '\n', bytes.size());
  if (newline == nullptr) {
    bytes = file_.peek(file_.capacity());
    newline = bytes.empty() ? nullptr : std::memchr(bytes.data(), '\n', bytes.size());
  }
  if (newline == nullptr && file_.error() != 0) return Line::failed;
  if (bytes.empty()) return Line::end;
  ++line_;
  if (newline == nullptr && bytes.size() == file_.capacity()) return Line::failed;
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  const auto length =
      newline == nullptr ? bytes.size() : static_cast<std::size_t>(static_cast<const char*>(newline) - text);
  line = {text, length};
  file_.consume(length + 1);  // the bytes remain valid until the next peek
  return Line::whole;
}

CsvSource::Column CsvSource::column_of(std::string_view name, const SensorSetup& sensor) const {
  Column column{std::string(name), Channel::ignored, 0};
  if (name == "time") {
    column.channel = Channel::time;
    return column;
  }
  if (name.size() < 3 || name[name.size() - 2] != '_' || name.back() < 'x' || name.back() > 'z')
    return column;
  const std::string_view taxel = name.substr(0, name.size() - 2);
  const auto found = std::find(names_.begin(), names_.end(), taxel);
  if (found == names_.end()) {
    if (!sensor.options.contains("taxels")) refuse_beyond_layout(name, sensor);
    return column;
  }
  const char axis = name.back();
  column.channel = axis == 'x' ? Channel::x : axis == 'y' ? Channel::y : Channel::z;
  column.taxel = static_cast<std::size_t>(found - names_.begin());
  return column;
}

// txl17 in a layout of 16 taxels is a mistake, unless the sensor says which taxels are its own.
void CsvSource::refuse_beyond_layout(std::string_view column, const SensorSetup& sensor) const {
  if (!column.starts_with("txl")) return;
  const std::string_view taxel = column.substr(0, column.size() - 2);
  const std::string_view digits = taxel.substr(3);
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || end != digits.data() + digits.size()) return;
  if (number >= 1 && number <= taxels_) return;  // such as txl01, which names no taxel
  throw DriverError(path_.string() + ": line 1, column " + std::to_string(columns_.size() + 1) + ": " +
                    std::string(column.substr(0, 24)) + " is beyond the " + std::to_string(taxels_) +
                    " taxels in the layout of sensor \"" + sensor.name +
                    "\": give the sensor the file's layout, or name its taxels with the option taxels");
}

// Without a column time, Time or timestamp are meant as one, and would be ignored.
void CsvSource::refuse_time_of_another_name() const {
  for (const Column& column : columns_) {
    std::string name = column.name;
    std::transform(name.begin(), name.end(), name.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    if (column.channel != Channel::ignored || (name != "t" && !name.starts_with("time"))) continue;
    throw DriverError(path_.string() + ": line 1, column " + std::to_string(&column - columns_.data() + 1) +
                      ": " + column.name.substr(0, 24) +
                      " is no name that is read: name it time if it is the rows' time in s, or take it out "
                      "if rows are to be spaced by rate_hz");
  }
}

void CsvSource::read_header(const SensorSetup& sensor) {
  std::string_view line;
  if (next_line(line) != Line::whole) {
    throw DriverError(path_.string() + ": line 1: " +
                      (file_.error() != 0 ? std::generic_category().message(file_.error())
                                          : "no line of column names (txl1_x, txl1_y, txl1_z ...)"));
  }
  if (line.substr(0, 3) == "\xEF\xBB\xBF") line.remove_prefix(3);
  std::vector<bool> seen(3 * taxels_ + 1, false);
  std::string_view field;
  while (next_field(line, field)) {
    columns_.push_back(column_of(field, sensor));
    const auto& column = columns_.back();
    if (column.channel == Channel::ignored) continue;
    const auto place = column.channel == Channel::time
                           ? 3 * taxels_
                           : 3 * column.taxel + static_cast<std::size_t>(column.channel) -
                                 static_cast<std::size_t>(Channel::x);
    if (seen[place]) {
      throw DriverError(path_.string() + ": line 1, column " + std::to_string(columns_.size()) +
                        ": a second column " + column.name);
    }
    seen[place] = true;
  }
  has_time_ = seen.back();
  const auto missing = std::find(seen.begin(), seen.end() - 1, false);
  if (missing != seen.end() - 1) {
    const auto place = static_cast<std::size_t>(missing - seen.begin());
    throw DriverError(path_.string() + ": line 1: no column " + names_[place / 3] + "_" + "xyz"[place % 3] +
                      ", but the layout of sensor \"" + sensor.name + "\" has " + std::to_string(taxels_) +
                      " taxels: give the sensor the file's layout, or name the file of the tactile sensor");
  }
  if (!has_time_) refuse_time_of_another_name();
  if (!has_time_ && !(rate_hz_ > 0)) {
    throw DriverError(path_.string() + ": has no column time: give the sensor a rate_hz");
  }
}

bool CsvSource::store(const Column& column, std::string_view field, FrameSlot& out,
                      bool& complete) const noexcept {
  if (column.channel == Channel::ignored) return true;
  double value = 0;
  if (!parse(field, value)) return false;
  complete &= std::isfinite(value);
  const auto as_float = static_cast<float>(value);
  switch (column.channel) {
    case Channel::x:
      out.shear_x_pa[column.taxel] = as_float;
      break;
    case Channel::y:
      out.shear_y_pa[column.taxel] = as_float;
      break;
    case Channel::z:
      out.normal_pa[column.taxel] = as_float;
      break;
    case Channel::time:
      if (std::abs(value) > kLatestSeconds) return false;
      if (std::isfinite(value)) out.time_ns = std::llround(value * 1e9);
      break;
    case Channel::ignored:
      break;
  }
  return true;
}

ReadOutcome CsvSource::next(FrameSlot& out) noexcept {
  if (fault_ != nullptr) return ReadOutcome::damaged;
  std::string_view line;
  std::size_t blank_bytes = 0;
  do {
    blank_bytes += line.size() + 1;
    if (blank_bytes > kMostBlankBytes)
      return fail(0, "the lines up to here are empty: no table of frames", {});
    switch (next_line(line)) {
      case Line::whole:
        break;
      case Line::end:
        return ReadOutcome::end;
      case Line::failed:
        return fail(0, file_.error() != 0 ? "cannot be read" : "is longer than any frame's", {});
    }
  } while (trimmed(line).empty());
  std::string_view field;
  std::size_t number = 0;
  bool complete = true;
  while (next_field(line, field)) {
    if (number == columns_.size())
      return fail(number + 1, "one field more than there are column names", field);
    if (!store(columns_[number], field, out, complete))
      return fail(number + 1, "no number that can be used", field);
    ++number;
  }
  if (number < columns_.size()) return fail(number + 1, "the line ends before this column", {});
  if (!has_time_) out.time_ns = std::llround(static_cast<double>(row_) * 1e9 / rate_hz_);
  out.sequence = row_++;
  out.device_time_ns = -1;
  out.truth = {};
  return complete ? ReadOutcome::frame : ReadOutcome::corrupt;
}

ReadOutcome CsvSource::fail(std::size_t column, const char* what, std::string_view field) noexcept {
  fault_ = what;
  fault_column_ = column;
  field_.fill('\0');
  std::copy_n(field.begin(), std::min(field.size(), field_.size() - 1), field_.begin());
  for (char& c : field_) {
    if (c != '\0' && (c < ' ' || c > '~')) c = '?';
  }
  return ReadOutcome::damaged;
}

std::string CsvSource::fault() const {
  if (fault_ == nullptr) return {};
  std::string text = path_.string() + ": line " + std::to_string(line_);
  if (fault_column_ != 0) text += ", column " + std::to_string(fault_column_);
  if (fault_column_ != 0 && fault_column_ <= columns_.size())
    text += " (" + columns_[fault_column_ - 1].name + ")";
  text += ": ";
  if (field_[0] != '\0') text += "\"" + std::string(field_.data()) + "\" is ";
  return text + fault_;
}

void CsvSource::rewind() noexcept {
  file_.rewind();
  std::string_view names;
  line_ = row_ = 0;
  fault_ = nullptr;
  next_line(names);
}

}  // namespace slipd::replay
