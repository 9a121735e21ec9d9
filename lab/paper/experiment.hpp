// One cell of the paper's experiment: a data set, its singular vectors, and the accuracy of classifying test
// columns by them.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "lab/paper/split.hpp"
#include "paper/dataset/paper_columns.hpp"

namespace lab {

// The parameters that vary. All others are the paper's: its skin and objects, a square grid of 14.4 mm (which
// the largest contact fills).
struct Experiment {
  slipd::Quantity quantity = slipd::Quantity::alpha;  // what a column consists of
  double noise = 0.04;  // half-width on the quantity itself, a fraction of each column's maximum
  double offset_m = 0;  // contacts lie up to this far off the middle, in x and in y
  slipd::DataSetSize size;
  std::size_t side = 100;        // taxels along each side
  std::vector<int> bases;        // numbers of bases for the random split, rising
  std::size_t column_tests = 0;  // test columns that are compared as a whole; 0: none
  std::uint64_t seed = 1;        // of contacts, noise and split
  unsigned threads = 2;
};

// Shares, 0 … 1.
struct Outcome {
  std::vector<double> variance;    // of the variance, explained by each base
  std::vector<double> random;      // accuracy for each of `bases`: random split, basis of all columns
  std::vector<double> by_contact;  // accuracy for each of `bases` up to kStrictBases: split by contact, basis
                                   // of the training contacts alone
  double random_columns = 0;       // accuracy by whole columns, random split
  double by_contact_columns = 0;   // accuracy by whole columns, split by contact
};

inline constexpr int kStrictBases = 20;

Outcome run(const Experiment& experiment, const std::function<void(double)>& progress = {});

// Coordinates on the first three bases of every column, and its Gamma: 4 x columns (the paper's figure 3).
Eigen::MatrixXf projections(const Experiment& experiment);

}  // namespace lab
