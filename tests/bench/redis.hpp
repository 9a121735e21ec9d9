// redis-server beside slipd: the peer of reading an estimate and of starting.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "tests/support/program.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::bench {

// GET of the value that Redis::set wrote; its answer has two ends of line.
inline constexpr const char* kRedisGet = "*2\r\n$3\r\nGET\r\n$1\r\nk\r\n";

// A server in a folder of its own, answering on a Unix socket without writing anything to disk.
class Redis {
 public:
  // None where it is not installed; says so. Has answered when it returns.
  static std::unique_ptr<Redis> start();
  std::filesystem::path socket() const { return folder_.file("r.sock"); }
  void set(const std::string& value) const;
  pid_t pid() const { return program_.pid(); }

 private:
  Redis();

  testing::TempFolder folder_;
  testing::Program program_;
};

}  // namespace slipd::bench
