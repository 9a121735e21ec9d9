// The paper's classifier (section III.B): the majority vote of the 5 nearest training columns on the class of
// Gamma. Exact search.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lab/paper/split.hpp"
#include "paper/dataset/column_source.hpp"

namespace lab {

// The k nearest so far, nearest first.
class Nearest {
 public:
  static constexpr std::size_t kCount = 5;
  void add(float distance, int slip_class) noexcept;
  void merge(const Nearest& other) noexcept;
  // The most frequent class; of equally frequent ones the lowest, which is nearest to slip.
  int vote() const noexcept;

 private:
  float distance_[kCount] = {1e30F, 1e30F, 1e30F, 1e30F, 1e30F};
  int class_[kCount] = {};
};

// The share of test columns that are classified correctly by their first `bases[i]` coordinates, for each i.
// `bases` rises. coordinates: rank x columns. classes: 1 … 5 of each column.
std::vector<double> accuracy_by_bases(const Eigen::MatrixXf& coordinates, const std::vector<int>& classes,
                                      const Split& split, const std::vector<int>& bases, unsigned threads);

// The same by whole columns, for `tests` evenly spaced test columns.
double accuracy_of_columns(const slipd::ColumnSource& columns, const std::vector<int>& classes,
                           const Split& split, std::size_t tests, unsigned threads);

}  // namespace lab
