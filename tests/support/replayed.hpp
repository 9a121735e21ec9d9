// The content of a recording on disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace slipd::testing {

struct Replayed {
  std::uint64_t frames = 0;
  std::uint64_t last_sequence = 0;
  bool in_order = true;  // sequence numbers rise
  std::string fault;     // why reading ended early; empty: the recording is whole
};

Replayed replay(const std::filesystem::path& file);

}  // namespace slipd::testing
