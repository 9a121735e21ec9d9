#include "tests/support/process_facts.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace slipd::testing {
namespace {

namespace fs = std::filesystem;

fs::path folder(pid_t process) {
  return fs::path("/proc") / std::to_string(process);
}

std::size_t entries(const fs::path& path) {
  std::size_t count = 0;
  std::error_code ignored;
  for (fs::directory_iterator each(path, ignored), end; each != end; each.increment(ignored)) ++count;
  return count;
}

}  // namespace

std::size_t resident_kb(pid_t process) {
  std::ifstream status(folder(process) / "status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("RssAnon:")) return std::stoul(line.substr(8));
  }
  return 0;
}

std::size_t open_descriptors(pid_t process) {
  return entries(folder(process) / "fd");
}

std::size_t threads(pid_t process) {
  return entries(folder(process) / "task");
}

std::string mapped_by(pid_t process) {
  std::ifstream maps(folder(process) / "maps");
  return {std::istreambuf_iterator<char>(maps), {}};
}

pid_t child_of(pid_t process) {
  std::error_code ignored;
  for (fs::directory_iterator each("/proc", ignored), end; each != end; each.increment(ignored)) {
    std::ifstream status(each->path() / "status");
    for (std::string line; std::getline(status, line);) {
      if (line == "PPid:\t" + std::to_string(process)) return std::stoi(each->path().filename().string());
    }
  }
  return 0;
}

}  // namespace slipd::testing
