// Sweeps in shards: their parts merge to the result of one run, or to an error that says what is wrong.
#include "tools/offline/sweep.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

namespace offline {
namespace {

using nlohmann::ordered_json;
using ::testing::HasSubstr;

constexpr std::size_t kUnits = 7;

// Unit 2 adds no row, unit n another n.
SweepResult sweep_of(const Shard& shard) {
  SweepResult sweep{{{"contacts", 5}, {"processor", "one"}}, {}};
  for (std::size_t unit = 0; unit < kUnits; ++unit) {
    for (std::size_t row = 0; unit != 2 && row <= unit; ++row) {
      if (shard.has(unit)) sweep.add_row(unit, {{"unit", unit}, {"row", row}});
    }
  }
  return sweep;
}

ordered_json part(const Shard& shard, std::uint64_t seed = 1) {
  Common common;
  common.seed = seed;
  CLI::App command("", "tradeoff");
  return part_of(sweep_of(shard), shard, common, command);
}

std::vector<std::string> names_of(std::size_t count) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) names.push_back("file " + std::to_string(i));
  return names;
}

std::string refusal_of(const std::vector<ordered_json>& parts) {
  try {
    merged(parts, names_of(parts.size()));
  } catch (const WrongUse& wrong) {
    return wrong.what();
  }
  return "none";
}

TEST(Shards, MergeToTheResultOfOneRunInAnyOrderAndNumber) {
  const ordered_json whole = assembled(sweep_of({}));
  for (const std::size_t of : {1UL, 2UL, 3UL, 7UL, 20UL}) {
    std::vector<ordered_json> parts;
    for (std::size_t i = of; i-- > 0;) parts.push_back(ordered_json::parse(part({i, of}).dump()));
    EXPECT_EQ(merged(parts, names_of(of)).dump(), whole.dump()) << of;
  }
}

TEST(Shards, HaveEachUnitOnce) {
  for (std::size_t unit = 0; unit < 20; ++unit) {
    int times = 0;
    for (std::size_t i = 0; i < 3; ++i) times += Shard{i, 3}.has(unit) ? 1 : 0;
    EXPECT_EQ(times, 1);
  }
}

TEST(Shards, OfOtherProcessorsNameThemAll) {
  std::vector<ordered_json> parts{part({0, 3}), part({1, 3}), part({2, 3})};
  parts[1]["head"]["processor"] = "another";
  EXPECT_EQ(merged(parts, names_of(3))["processor"], "one; another");
}

TEST(Shards, AreWrittenFromOne) {
  EXPECT_EQ(shard_of("2/8").index, 1U);
  EXPECT_EQ(shard_of("2/8").of, 8U);
  EXPECT_TRUE(shard_of("1/1").whole());
  for (const char* text :
       {"", "1", "0/2", "3/2", "a/2", "1/2x", "-1/2", "1/", "/2", "1/99999999999999999999"})
    EXPECT_THROW(shard_of(text), WrongUse) << text;
}

TEST(Merging, SaysWhatIsMissingDoubleOrOfAnotherSweep) {
  EXPECT_THAT(refusal_of({}), HasSubstr("no parts"));
  EXPECT_THAT(refusal_of({part({0, 4}), part({2, 4})}), HasSubstr("missing: 2/4, 4/4"));
  EXPECT_THAT(refusal_of({part({0, 2}), part({0, 2})}), HasSubstr("file 0 and file 1 are the same part"));
  EXPECT_THAT(refusal_of({part({0, 2}), part({1, 2}, 2)}), HasSubstr("settings differs"));
  EXPECT_THAT(refusal_of({part({0, 2}), part({1, 3})}), HasSubstr("number of shards"));
  EXPECT_THAT(refusal_of({part({0, 2}), {{"rows", 1}}}), HasSubstr("file 1 is no part of a sweep"));
  ordered_json other = part({1, 2});
  other["head"]["contacts"] = 6;
  EXPECT_THAT(refusal_of({part({0, 2}), other}), HasSubstr("contacts differs, 5 and 6"));
}

TEST(Shards, WriteNoFiles) {
  Common common;
  common.out = "folder";
  EXPECT_THROW(refuse_files(Shard{0, 2}, common), WrongUse);
  EXPECT_NO_THROW(refuse_files(Shard{}, common));
}

}  // namespace
}  // namespace offline
