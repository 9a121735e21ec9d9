#include "bridges/support/log.hpp"

#include <unistd.h>

#include <cstdio>
#include <string>

#include "schema/json_text.hpp"

namespace slipd::bridges {
namespace {

LogLevel shown_level = LogLevel::info;

}  // namespace

void set_log_level(LogLevel most) noexcept {
  shown_level = most;
}

void log(LogLevel level, std::string_view text) {
  if (level > shown_level) return;
  static const bool kTerminal = isatty(STDERR_FILENO) == 1;
  const std::string line =
      (kTerminal ? "" : "<" + std::to_string(static_cast<int>(level)) + ">") + plain(text) + "\n";
  std::fwrite(line.data(), 1, line.size(), stderr);  // unbuffered: one write
}

}  // namespace slipd::bridges
