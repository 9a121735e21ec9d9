#include "bridges/ros2/recorder.hpp"

#include <algorithm>
#include <filesystem>

#include "bridges/support/log.hpp"

namespace slipd::ros2 {

namespace {

// Recordings of one name: more than any number of restarts and reloads.
constexpr int kMostFiles = 10000;

// `file`, or "FILE-2.mcap" and so on if that exists, as after a reload.
std::string free_name(const std::string& file) {
  std::filesystem::path path = file;
  const std::string stem = path.stem();
  const std::string extension = path.extension();
  for (int i = 2; i < kMostFiles && std::filesystem::exists(path); ++i)
    path.replace_filename(std::string(stem).append("-").append(std::to_string(i)).append(extension));
  return path;
}

}  // namespace

Recorder::Recorder(const std::string& file) {
  if (file.empty()) return;
  const std::string name = free_name(file);
  writer_ = std::make_unique<McapWriter>(name, McapOptions{.library = "slipd-ros2"});
  records_ = true;
  bridges::log(bridges::LogLevel::notice, "records into " + name);
}

Recorder::~Recorder() {
  try {
    if (writer_) writer_->close();
  } catch (const std::exception& error) {
    fail(error);
  }
}

std::uint16_t Recorder::channel(std::string_view topic, const std::vector<Definition>& definitions,
                                std::string_view hash) {
  const std::lock_guard lock(mutex_);
  const auto known = std::find(topics_.begin(), topics_.end(), topic);
  if (known != topics_.end()) return static_cast<std::uint16_t>(known - topics_.begin());
  if (!writer_) return 0;
  topics_.emplace_back(topic);
  return writer_->add_channel(topic, definitions, hash);
}

void Recorder::append(std::uint16_t channel, std::int64_t realtime_ns) {
  try {
    writer_->write(channel, static_cast<std::uint64_t>(std::max<std::int64_t>(0, realtime_ns)), bytes_);
  } catch (const std::exception& error) {
    fail(error);
  }
}

void Recorder::fail(const std::exception& error) {
  bridges::log(bridges::LogLevel::error, std::string("the recording has ended: ") + error.what());
  records_ = false;
  writer_.reset();
}

}  // namespace slipd::ros2
