// Clients of a Unix socket that ask, wait for the answer, and ask again: the same for slipd and for its
// peers, so that what the client costs is the same as well. One thread.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/bench/times.hpp"

namespace slipd::bench {

struct Asking {
  std::filesystem::path socket;
  std::string request;  // with its end
  int newlines = 1;     // in each answer
  int clients = 1;
  int subscribers = 0;  // more connections, which have sent `subscription` and throw away what they hear
  std::string subscription = {};
};

struct Asked {
  double per_second = 0;
  Quantiles waits;
  std::size_t answer_bytes = 0;
  std::uint64_t heard = 0;  // lines, by all subscribers
};

// Throws std::system_error.
Asked ask_for(const Asking& asking, std::chrono::milliseconds long_enough);

// A connected socket. Throws std::system_error.
int connect_to(const std::filesystem::path& socket);

}  // namespace slipd::bench
