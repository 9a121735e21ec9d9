// One cell of the paper's experiment: a data set, its singular vectors, and how many of the test columns'
// classes are found from them.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "core/model/paper_columns.hpp"
#include "tools/sliplab/paper/split.hpp"

namespace sliplab {

// What is varied. The rest is the paper's: its skin and objects, a square grid of 14.4 mm (the largest
// contact just fits).
struct Experiment {
  slipd::Quantity quantity = slipd::Quantity::alpha;
  double noise = 0.04;  // of each column's maximum, on the quantity itself
  double offset_m = 0;
  slipd::DataSetSize size;
  std::size_t side = 100;        // taxels
  std::vector<int> bases;        // numbers of bases for the random split, rising
  std::size_t column_tests = 0;  // test columns compared as a whole; 0: none
  std::uint64_t seed = 1;
  unsigned threads = 2;
};

struct Outcome {
  std::vector<double> variance;  // share that each base explains
  std::vector<double> random;    // accuracy for each of `bases`, split at random, basis of all columns
  std::vector<double>
      by_contact;  // for those of `bases` up to kStrictBases; basis of the training contacts alone
  double random_columns = 0, by_contact_columns = 0;  // from whole columns
};

inline constexpr int kStrictBases = 20;

Outcome run(const Experiment& experiment, const std::function<void(double)>& progress = {});

// Coordinates on the first three bases of every column, and its Gamma: 4 x columns (the paper's figure 3).
Eigen::MatrixXf projections(const Experiment& experiment);

}  // namespace sliplab
