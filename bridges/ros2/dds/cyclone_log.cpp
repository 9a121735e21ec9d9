#include "bridges/ros2/dds/cyclone_log.hpp"

#include <dds/ddsrt/log.h>

#include <utility>

#include "bridges/support/log.hpp"

namespace slipd::ros2 {
namespace {

// Cyclone's threads.
void take_line(void* refused, const dds_log_data_t* line) {
  std::string_view text(line->message, line->size);
  while (text.ends_with('\n')) text.remove_suffix(1);
  const auto topic = topic_of_refusal(text);
  if (topic && (*static_cast<CycloneLog::Refused*>(refused))(*topic)) return;
  bridges::log((line->priority & (DDS_LC_FATAL | DDS_LC_ERROR)) != 0 ? bridges::LogLevel::error
                                                                     : bridges::LogLevel::warning,
               text);
}

}  // namespace

std::optional<std::string_view> topic_of_refusal(std::string_view line) {
  constexpr std::string_view kBegin = "deserialization rt/";
  const std::size_t begin = line.find(kBegin), failed = line.find(" failed", begin);
  if (begin == std::string_view::npos || failed == std::string_view::npos) return std::nullopt;
  // With its first slash; the type stands behind the last one, and has none.
  const std::size_t from = begin + kBegin.size() - 1;
  const std::size_t type = line.substr(0, failed).rfind('/');
  if (type <= from) return std::nullopt;
  return line.substr(from, type - from);
}

CycloneLog::CycloneLog(Refused refused) : refused_(std::move(refused)) {
  dds_set_log_sink(&take_line, &refused_);
}

CycloneLog::~CycloneLog() {
  dds_set_log_sink(nullptr, nullptr);
}

}  // namespace slipd::ros2
