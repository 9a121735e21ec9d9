#include "tests/bench/running.hpp"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/bench/scenes.hpp"

namespace slipd::bench {

using nlohmann::json;

json trial(const std::string& name, std::size_t side, double rate_hz, const json& options) {
  json sensor{{"name", name},
              {"driver", "trial"},
              {"rate_hz", rate_hz},
              {"layout", {{"grid", {side, side}}, {"pitch_mm", 1e3 * kPad_m / static_cast<double>(side)}}}};
  if (!options.is_null()) sensor["options"] = options;
  return sensor;
}

json config(const testing::TempFolder& folder, const json& sensors, const std::string& method,
            const json& more) {
  json all{{"estimator", {{"method", method}, {"noise", kNoise}, {"offset_mm", method == "svd-knn" ? 0 : 2}}},
           {"socket", {{"path", folder.file("s.sock").string()}, {"max_clients", 512}}},
           {"log", {{"level", "error"}}}};
  all.merge_patch(more);
  return testing::config_with(folder, sensors, all);
}

testing::Program::Environment state() {
  return {{"STATE_DIRECTORY", std::filesystem::absolute(bench::folder()).string()}};
}

void wait_for_estimates(const testing::Daemon& daemon, std::uint64_t count) {
  daemon.wait_for("status", [&](const json& status) {
    for (const json& sensor : status["sensors"]) {
      if (sensor["estimated"].get<std::uint64_t>() < count) return false;
    }
    return true;
  });
}

Usage usage_of(pid_t pid) {
  Usage usage;
  const std::string folder = "/proc/" + std::to_string(pid) + "/";
  std::ifstream stat(folder + "stat");
  std::string text;
  std::getline(stat, text);
  std::istringstream fields(text.substr(text.rfind(')') + 2));
  double user = 0, system = 0;
  for (int i = 3; fields >> text; ++i) {
    if (i == 14) user = std::stod(text);
    if (i == 15) system = std::stod(text);
  }
  usage.cpu_s = (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
  std::ifstream status(folder + "status");
  while (std::getline(status, text)) {
    const auto take = [&](const char* name, double& mb) {
      if (text.starts_with(name)) mb = std::stod(text.substr(text.find(':') + 1)) / 1024;
    };
    take("VmRSS:", usage.resident_mb);
    take("VmLck:", usage.locked_mb);
    take("RssAnon:", usage.own_mb);
  }
  return usage;
}

double thread_cpu_s(pid_t pid) {
  double sum_s = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/" + std::to_string(pid) + "/task")) {
    std::ifstream file(task.path() / "schedstat");
    double ran_ns = 0;
    file >> ran_ns;
    sum_s += 1e-9 * ran_ns;
  }
  return sum_s;
}

}  // namespace slipd::bench
