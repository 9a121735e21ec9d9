#include "daemon/log/log.hpp"

#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "daemon/log/datagram.hpp"
#include "daemon/log/journal.hpp"
#include "daemon/rt/environment.hpp"

namespace slipd {
namespace {

spdlog::level::level_enum spdlog_level(LogLevel level) {
  static constexpr spdlog::level::level_enum kLevels[] = {spdlog::level::debug, spdlog::level::info,
                                                          spdlog::level::warn, spdlog::level::err};
  return kLevels[static_cast<std::size_t>(level)];
}

// systemd sets JOURNAL_STREAM to device and inode of the stream that it connected to the journal.
bool on_journal() {
  struct stat status {};
  return fstat(STDERR_FILENO, &status) == 0 &&
         environment_variable("JOURNAL_STREAM") ==
             std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino);
}

std::string lost_lines(std::uint64_t lost) {
  return std::to_string(lost) + " log lines found no room and are lost";
}

// Empty fields are left out. False: journald has no room for it.
bool send_to_journal(spdlog::level::level_enum level, const LogContext& context, std::string_view text) {
  static constexpr std::string_view kPriorities[] = {"7", "7", "6", "4", "3", "2", "6"};
  JournalEntry entry;
  entry.add("MESSAGE", text)
      .add("PRIORITY", kPriorities[static_cast<std::size_t>(level)])
      .add("SYSLOG_IDENTIFIER", "slipd");
  if (!context.sensor.empty()) entry.add("SLIPD_SENSOR", context.sensor);
  if (context.cause != Cause::none) entry.add("SLIPD_CAUSE", to_string(context.cause));
  return send_datagram(kJournald, entry.bytes(), WhenFull::lose);
}

// Lines that journald had no room for are counted, and their number is logged before the next line that it
// takes.
void write_to_journal(spdlog::level::level_enum level, const LogContext& context, std::string_view text) {
  static std::atomic<std::uint64_t> lost{0};  // relaxed: an independent count
  if (const std::uint64_t told = lost.load(std::memory_order_relaxed);
      told > 0 && send_to_journal(spdlog::level::warn, {{}, Cause::slipd}, lost_lines(told)))
    lost.fetch_sub(told, std::memory_order_relaxed);
  if (!send_to_journal(level, context, text)) lost.fetch_add(1, std::memory_order_relaxed);
}

class JournalSink : public spdlog::sinks::base_sink<std::mutex> {
  void sink_it_(const spdlog::details::log_msg& message) override {
    write_to_journal(message.level, {}, {message.payload.data(), message.payload.size()});
  }
  void flush_() override {}
};

bool journal = false;  // written by set_up_log only, before other threads start

}  // namespace

void set_up_log(const std::string& level) {
  journal = on_journal();
  spdlog::sink_ptr sink;
  if (journal) {
    sink = std::make_shared<JournalSink>();
  } else {
    sink = std::make_shared<spdlog::sinks::stderr_sink_mt>();
  }
  auto logger = std::make_shared<spdlog::logger>("slipd", std::move(sink));
  logger->set_pattern("%H:%M:%S.%e %^%-7l%$ %v");
  logger->set_level(spdlog::level::from_str(level));
  logger->flush_on(spdlog::level::trace);
  spdlog::set_default_logger(std::move(logger));
}

void change_log_level(const std::string& level) {
  spdlog::default_logger_raw()->set_level(spdlog::level::from_str(level));
}

void write_log(LogLevel level, const LogContext& context, std::string_view text) {
  const auto at = spdlog_level(level);
  if (!spdlog::default_logger_raw()->should_log(at)) return;
  if (journal) return write_to_journal(at, context, text);
  spdlog::log(at, "{}", text);
}

void drain_logs(std::list<LogRing>& rings, LogLimit& limit) {
  const auto now = LogLimit::Clock::now();
  LogLine line;
  for (LogRing& ring : rings) {
    while (ring.read(line)) {
      if (limit.admits(line, now))
        write_log(line.level, {static_cast<const char*>(line.sensor), line.cause},
                  static_cast<const char*>(line.text));
    }
    if (const auto lost = ring.take_lost(); lost > 0)
      write_log(LogLevel::warning, {{}, Cause::slipd}, lost_lines(lost));
  }
  for (const LogLimit::Suppressed& suppressed : limit.take_expired(now)) {
    const LogLine& last = suppressed.last;
    write_log(last.level, {static_cast<const char*>(last.sensor), last.cause},
              std::string(static_cast<const char*>(last.text)) + " (and " + std::to_string(suppressed.count) +
                  " times more within " +
                  (suppressed.within.count() == 1 ? "a minute"
                                                  : std::to_string(suppressed.within.count()) + " minutes") +
                  ")");
  }
}

}  // namespace slipd
