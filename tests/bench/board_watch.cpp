#include "tests/bench/board_watch.hpp"

#include <fcntl.h>

#include <filesystem>
#include <stdexcept>
#include <thread>
#include <utility>

namespace slipd::bench {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

constexpr double kAttachPatienceS = 10;

UniqueFd shared_memory(pid_t pid) {
  for (const auto& file : fs::directory_iterator("/proc/" + std::to_string(pid) + "/fd")) {
    std::error_code gone;
    if (fs::read_symlink(file.path(), gone).string().find("slipd-board") == std::string::npos) continue;
    UniqueFd fd(open(file.path().c_str(), O_RDONLY | O_CLOEXEC));
    if (fd) return fd;
  }
  throw std::runtime_error("slipd has no shared memory");
}

}  // namespace

BoardWatch::BoardWatch(const testing::Daemon& daemon, const std::string& sensor) {
  slipd_client* client = nullptr;
  slipd_open(&client, daemon.socket().c_str());
  client_.reset(client);
  if (slipd_attach(client, sensor.c_str(), kAttachPatienceS) != SLIPD_DONE)
    throw std::runtime_error(slipd_error_text(client));
  if (const std::string why = view_.map(shared_memory(daemon.program().pid())); !why.empty())
    throw std::runtime_error(why);
  seen_.resize(view_.slots());
}

std::vector<SeenEstimate> BoardWatch::sample(std::chrono::nanoseconds how_long, std::size_t looks_a_second) {
  std::vector<SeenEstimate> estimates;
  const auto pause = std::chrono::nanoseconds(1s) / looks_a_second;
  const auto until = std::chrono::steady_clock::now() + how_long;
  for (auto due = std::chrono::steady_clock::now(); due < until; due += pause) {
    std::this_thread::sleep_until(due);
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      const auto record = view_.record(static_cast<int>(i));
      if (std::exchange(seen_[i], record.number) != record.number && record.time_ns > 0)
        estimates.push_back({record.number, record.time_ns, record.published_ns});
    }
  }
  return estimates;
}

}  // namespace slipd::bench
