#include "lab/paper/vote.hpp"

#include <algorithm>
#include <array>
#include <thread>

#include "paper/dataset/blocks.hpp"

namespace lab {

using Eigen::Index;

void Nearest::add(float distance, int slip_class) noexcept {
  if (!(distance < distance_[kCount - 1])) return;
  std::size_t at = kCount - 1;
  for (; at > 0 && distance_[at - 1] > distance; --at) {
    distance_[at] = distance_[at - 1];
    class_[at] = class_[at - 1];
  }
  distance_[at] = distance;
  class_[at] = slip_class;
}

void Nearest::merge(const Nearest& other) noexcept {
  for (std::size_t i = 0; i < kCount; ++i) add(other.distance_[i], other.class_[i]);
}

int Nearest::vote() const noexcept {
  std::array<int, 6> votes{};
  for (const int c : class_) ++votes[static_cast<std::size_t>(c)];
  return static_cast<int>(std::max_element(votes.begin(), votes.end()) - votes.begin());
}

std::vector<double> accuracy_by_bases(const Eigen::MatrixXf& coordinates, const std::vector<int>& classes,
                                      const Split& split, const std::vector<int>& bases, unsigned threads) {
  const auto trained = static_cast<Index>(split.train.size());
  Eigen::MatrixXf train(trained, coordinates.rows());  // a coordinate of all columns side by side
  for (Index i = 0; i < trained; ++i) {
    train.row(i) = coordinates.col(static_cast<Index>(split.train[static_cast<std::size_t>(i)])).transpose();
  }
  std::vector<std::vector<std::size_t>> right(threads, std::vector<std::size_t>(bases.size(), 0));
  const auto work = [&](unsigned worker) {
    Eigen::ArrayXf distance(trained);
    for (std::size_t t = worker; t < split.test.size(); t += threads) {
      const auto point = coordinates.col(static_cast<Index>(split.test[t]));
      distance.setZero();
      Index added = 0;
      for (std::size_t b = 0; b < bases.size(); ++b) {
        for (; added < bases[b]; ++added) distance += (train.col(added).array() - point[added]).square();
        Nearest nearest;
        for (Index i = 0; i < trained; ++i)
          nearest.add(distance[i], classes[split.train[static_cast<std::size_t>(i)]]);
        right[worker][b] += nearest.vote() == classes[split.test[t]] ? 1U : 0U;
      }
    }
  };
  std::vector<std::thread> others;
  for (unsigned w = 1; w < threads; ++w) others.emplace_back(work, w);
  work(0);
  for (auto& thread : others) thread.join();
  std::vector<double> accuracy(bases.size(), 0);
  for (const auto& part : right) {
    for (std::size_t b = 0; b < bases.size(); ++b) accuracy[b] += static_cast<double>(part[b]);
  }
  for (double& share : accuracy) share /= static_cast<double>(split.test.size());
  return accuracy;
}

double accuracy_of_columns(const slipd::ColumnSource& columns, const std::vector<int>& classes,
                           const Split& split, std::size_t tests, unsigned threads) {
  tests = std::min(tests, split.test.size());
  const auto rows = static_cast<Index>(columns.rows());
  Eigen::MatrixXf points(rows, static_cast<Index>(tests));
  std::vector<int> truth;
  for (std::size_t t = 0; t < tests; ++t) {
    const std::size_t column = split.test[t * split.test.size() / tests];
    columns.fill(column, 1, points.col(static_cast<Index>(t)).data());
    truth.push_back(classes[column]);
  }
  std::vector<bool> trains(columns.columns(), false);
  for (const std::size_t column : split.train) trains[column] = true;
  std::array<std::vector<Nearest>, slipd::kLanes> nearest;
  nearest.fill(std::vector<Nearest>(tests));
  slipd::for_each_block(columns, threads, [&](const slipd::Block& block) {
    // |x - t|² without |t|², which is the same for all x.
    const Eigen::MatrixXf products = block.values.transpose() * points;
    for (Index c = 0; c < block.values.cols(); ++c) {
      const std::size_t column = block.first + static_cast<std::size_t>(c);
      if (!trains[column]) continue;
      const float square = block.values.col(c).squaredNorm();
      for (std::size_t t = 0; t < tests; ++t) {
        nearest[block.lane][t].add(square - 2 * products(c, static_cast<Index>(t)), classes[column]);
      }
    }
  });
  std::size_t right = 0;
  for (std::size_t t = 0; t < tests; ++t) {
    for (std::size_t lane = 1; lane < slipd::kLanes; ++lane) nearest[0][t].merge(nearest[lane][t]);
    right += nearest[0][t].vote() == truth[t] ? 1U : 0U;
  }
  return static_cast<double>(right) / static_cast<double>(tests);
}

}  // namespace lab
