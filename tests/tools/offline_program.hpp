// sliplab or slipd-lab, run with a folder of its own.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/tools/run_program.hpp"

namespace slipctl::testing {

class OfflineProgram : public ::testing::Test {
 protected:
  using Words = std::vector<std::string>;

  // `program`: its name in the build's folder of programs.
  explicit OfflineProgram(const std::string& program)
      : program_(SLIPD_BINARY_DIR "/bin/" + program),
        folder_(std::filesystem::temp_directory_path() / (program + "-test-" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~OfflineProgram() override { std::filesystem::remove_all(folder_); }

  Ran run(const Words& arguments) const { return run_program(program_, arguments); }
  // Returns the file's path.
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  // The sweep in three shards, merged in any order, is that of one run; a shard that is missing is named.
  void expect_shards_merge(const Words& sweep) const {
    Words words{"--json"}, merge{"merge"};
    words.insert(words.end(), sweep.begin(), sweep.end());
    const auto whole = run(words);
    ASSERT_EQ(whole.exit_code, 0) << whole.err;
    for (const std::string shard : {"2/3", "3/3", "1/3"}) {
      words = sweep;
      words.insert(words.end(), {"--shard", shard});
      const auto part = run(words);
      ASSERT_EQ(part.exit_code, 0) << part.err;
      merge.push_back(write(sweep.front() + shard.substr(0, 1), part.out));
    }
    const auto joined = run(merge);
    EXPECT_EQ(joined.exit_code, 0) << joined.err;
    EXPECT_EQ(joined.out, whole.out) << sweep.front();
    merge.pop_back();
    const auto missing = run(merge);
    EXPECT_EQ(missing.exit_code, 2);
    EXPECT_THAT(missing.err, ::testing::HasSubstr("missing: 1/3"));
  }

  const std::string program_;
  const std::filesystem::path folder_;
};

}  // namespace slipctl::testing
