#include "daemon/telemetry/metrics_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "core/storage/unique_fd.hpp"
#include "daemon/log/log.hpp"
#include "daemon/telemetry/metrics.hpp"

namespace slipd {
namespace {

std::error_code last_error() {
  return {errno, std::generic_category()};
}

std::error_code replace(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::path aside = file;
  aside += ".new";
  const UniqueFd fd(open(aside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0644));
  if (!fd) return last_error();
  fchmod(fd.get(), 0644);  // independent of the umask
  std::error_code error;
  const auto written = write(fd.get(), text.data(), text.size());
  if (written < 0) error = last_error();
  if (written >= 0 && static_cast<std::size_t>(written) < text.size())
    error = std::make_error_code(std::errc::no_space_on_device);
  if (!error) std::filesystem::rename(aside, file, error);
  std::error_code ignored;
  if (error) std::filesystem::remove(aside, ignored);
  return error;
}

}  // namespace

MetricsFile::~MetricsFile() {
  std::error_code ignored;
  if (!settings_.file.empty()) std::filesystem::remove(settings_.file, ignored);
}

void MetricsFile::write_if_due(const ServiceContext& context, std::chrono::steady_clock::time_point now) {
  if (settings_.file.empty() || now < due_) return;
  due_ = now + settings_.period;
  const std::error_code error = replace(settings_.file, metrics_text(context, MetricsFormat::prometheus));
  if (error && !refused_) {
    write_log(LogLevel::warning, {{}, Cause::configuration},
              "metrics.file: " + settings_.file.string() + " cannot be written: " + error.message() +
                  "; the service may write below /run/slipd");
  }
  refused_ = static_cast<bool>(error);
}

}  // namespace slipd
