// slipd-lab itself, as a developer runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/tools/offline_program.hpp"

namespace {

using nlohmann::json;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class Lab : public slipctl::testing::OfflineProgram {
 protected:
  Lab() : OfflineProgram("slipd-lab") {}
};

TEST_F(Lab, PaperGivesTableJsonAndFigures) {
  const auto table = run({"paper", "--fast", "--seeds", "2", "--out", folder_ / "figures"});
  ASSERT_EQ(table.exit_code, 0) << table.err;
  EXPECT_THAT(table.out, HasSubstr("split by contact"));
  for (const char* name : {"figure3.csv", "figure3.svg", "figure4.csv", "figure4.svg"}) {
    EXPECT_GT(fs::file_size(folder_ / "figures" / name), 500U) << name;
  }
  const auto result = json::parse(run({"--json", "paper", "--fast", "--seeds", "1"}).out);
  EXPECT_GE(result["rows"].size(), 6U);
  for (const auto& row : result["rows"]) {
    for (const auto& cell : row["knn"]) {
      EXPECT_GE(cell["random"]["mean"], 0.0);
      EXPECT_LE(cell["random"]["mean"], 1.0);
    }
  }
}

TEST_F(Lab, StabilityPrintsTheRequestedPartsAndPlotsThem) {
  const auto ran = run({"--json", "stability", "--parts", "model,adversary", "--contacts", "3", "--side",
                        "16", "--out", folder_ / "stability"});
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto result = json::parse(ran.out);
  EXPECT_GT(result["model"].size(), 50U);
  EXPECT_GT(result["adversary"].size(), 100U);
  EXPECT_TRUE(result["condition"].empty());
  for (const char* name : {"extremes-model.csv", "extremes-model.svg", "adversary.csv", "adversary.svg"})
    EXPECT_GT(fs::file_size(folder_ / "stability" / name), 500U) << name;
  EXPECT_EQ(run({"stability", "--parts", "luck"}).exit_code, 2);
}

TEST_F(Lab, TradeoffPrintsEverySettingAndPlotsTheFront) {
  const auto ran =
      run({"--json", "tradeoff", "--layouts", "8,wrench", "--contacts", "10", "--out", folder_ / "tradeoff"});
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  std::set<std::string> methods;
  std::set<int> rings;
  const auto result = json::parse(ran.out);
  for (const auto& row : result["rows"]) {
    methods.insert(row["method"]);
    rings.insert(row["rings"].get<int>());
  }
  EXPECT_EQ(methods, (std::set<std::string>{"moments", "fit", "svd-knn", "registered", "friction"}));
  EXPECT_EQ(rings, (std::set<int>{0, 4, 8, 16}));
  for (const char* name : {"tradeoff.csv", "tradeoff.svg"})
    EXPECT_GT(fs::file_size(folder_ / "tradeoff" / name), 500U) << name;
}

TEST_F(Lab, HistoriesPrintsTheAnswersAndDrawsAGrasp) {
  const auto ran = run({"--json", "histories", "--grasps", "2", "--sides", "16", "--methods", "moments",
                        "--out", folder_ / "histories"});
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto row = json::parse(ran.out)["rows"][0];
  EXPECT_EQ(row["method"], "moments");
  EXPECT_GT(row["all"]["answered"], 0.5);
  EXPECT_LE(row["all"]["claims_safer"], 1.0);
  for (const char* name : {"histories.csv", "histories.svg", "grasp-moments-16.csv"})
    EXPECT_GT(fs::file_size(folder_ / "histories" / name), 500U) << name;
  EXPECT_EQ(run({"histories", "--methods", "guess"}).exit_code, 2);
}

TEST_F(Lab, MergesTheShardsOfASweepToTheResultOfOneRun) {
  const std::vector<std::vector<std::string>> sweeps{
      {"histories", "--grasps", "1", "--sides", "8,4", "--methods", "moments,fit"},
      {"stability", "--contacts", "1", "--parts", "model,extremes"}};
  for (const auto& sweep : sweeps) expect_shards_merge(sweep);
}

}  // namespace
