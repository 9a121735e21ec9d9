// The parts of `slipd-lab paper`, compared with direct computations.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/numeric/random.hpp"
#include "lab/paper/experiment.hpp"
#include "lab/paper/split.hpp"
#include "lab/paper/vote.hpp"
#include "tests/paper/matrix_source.hpp"

namespace lab {
namespace {

constexpr slipd::DataSetSize kSize{.contacts = 30, .loads = 10};

TEST(Split, PutsEachColumnOnOneSideAndSeventyPerCentInTraining) {
  for (const auto kind : {SplitKind::random, SplitKind::by_contact}) {
    const Split split = split_of(kind, kSize, 4);
    EXPECT_EQ(split.train.size(), 210U);
    std::set<std::size_t> all(split.train.begin(), split.train.end());
    all.insert(split.test.begin(), split.test.end());
    EXPECT_EQ(all.size(), kSize.columns());
  }
}

TEST(Split, ByContactHasNoContactOnBothSides) {
  const Split split = split_of(SplitKind::by_contact, kSize, 4);
  std::set<std::size_t> trained;
  for (const std::size_t j : split.train) trained.insert(j / kSize.loads);
  for (const std::size_t j : split.test) EXPECT_FALSE(trained.contains(j / kSize.loads));
}

TEST(Split, DiffersFromSeedToSeed) {
  EXPECT_NE(split_of(SplitKind::random, kSize, 1).train, split_of(SplitKind::random, kSize, 2).train);
}

TEST(Nearest, VotesByMajorityOfTheFiveNearest) {
  Nearest nearest;
  for (const float d : {9.0F, 8.0F, 7.0F}) nearest.add(d, 1);
  for (const float d : {5.0F, 1.0F, 3.0F}) nearest.add(d, 4);
  EXPECT_EQ(nearest.vote(), 4);
  Nearest tie;
  tie.add(1, 5);
  tie.add(2, 5);
  tie.add(3, 2);
  tie.add(4, 2);
  tie.add(5, 3);
  EXPECT_EQ(tie.vote(), 2) << "of equals the one nearer to slip";
}

// With as many bases as rows, coordinates are the columns themselves.
TEST(Accuracy, OnAllCoordinatesIsThatOfWholeColumns) {
  const slipd::testing::MatrixSource source(slipd::testing::random_matrix(6, 300, 8));
  std::vector<int> classes;
  for (Eigen::Index j = 0; j < 300; ++j) classes.push_back(source.matrix()(0, j) > 0 ? 2 : 5);
  const Split split = split_of(SplitKind::random, kSize, 3);
  const auto by_bases = accuracy_by_bases(source.matrix(), classes, split, {1, 6}, 2);
  EXPECT_DOUBLE_EQ(by_bases[1], accuracy_of_columns(source, classes, split, 1000, 2));
  EXPECT_GT(by_bases[0], 0.95) << "the first coordinate says the class";
  EXPECT_LT(by_bases[1], by_bases[0]) << "the others only blur it";
}

Experiment small(double noise) {
  return {.noise = noise,
          .size = {.contacts = 40, .loads = 20},
          .side = 20,
          .bases = {1, 3, 8},
          .column_tests = 100};
}

TEST(PaperExperiment, MoreBasesTellMoreAndContactsUnseenAreHarder) {
  const Outcome outcome = run(small(0.02));
  EXPECT_GT(outcome.random[1], outcome.random[0]);
  EXPECT_GT(outcome.random[2], 0.6);
  EXPECT_TRUE(std::is_sorted(outcome.variance.rbegin(), outcome.variance.rend()));
}

TEST(PaperExperiment, NoiseTakesVarianceFromTheFirstBases) {
  const auto first_eight = [](double noise) {
    double sum = 0;
    for (const double share : run(small(noise)).variance) sum += share;
    return sum;
  };
  EXPECT_GT(first_eight(0), first_eight(0.1));
  EXPECT_GT(first_eight(0.1), first_eight(1));
}

}  // namespace
}  // namespace lab
