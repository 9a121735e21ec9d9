#include "lab/paper/experiment.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/contact/scene.hpp"
#include "core/estimate/estimate.hpp"
#include "lab/paper/vote.hpp"
#include "paper/basis/svd.hpp"

namespace lab {
namespace {

using namespace slipd;

constexpr double kWidthM = 0.0144;

Scene scene_of(const Experiment& experiment) {
  Scene scene;
  scene.objects = paper_objects();
  scene.noise = experiment.noise;
  scene.offset_m = experiment.offset_m;
  return scene;
}

// Folded where distances between columns and singular values do not change by it.
PaperColumns columns_of(const Experiment& experiment) {
  const auto layout =
      TaxelLayout::grid(experiment.side, experiment.side, kWidthM / static_cast<double>(experiment.side));
  const bool symmetric = experiment.noise == 0 && experiment.offset_m == 0;
  return {symmetric ? TaxelSet(layout, *fold(layout)) : TaxelSet(layout), scene_of(experiment),
          experiment.size, experiment.seed, experiment.quantity};
}

// A subset of another source's columns.
class Selected final : public ColumnSource {
 public:
  Selected(const ColumnSource& of, const std::vector<std::size_t>& which) : of_(of), which_(which) {}
  std::size_t rows() const noexcept override { return of_.rows(); }
  std::size_t columns() const noexcept override { return which_.size(); }
  void fill(std::size_t first, std::size_t count, float* out) const override {
    // Adjacent columns in one call, so that each contact is averaged over the taxels once.
    for (std::size_t i = 0; i < count;) {
      std::size_t run = 1;
      while (i + run < count && which_[first + i + run] == which_[first + i] + run) ++run;
      of_.fill(which_[first + i], run, out + i * rows());
      i += run;
    }
  }

 private:
  const ColumnSource& of_;
  const std::vector<std::size_t>& which_;
};

// The leading singular values converge in few passes; the smaller ones consist of noise and need not
// converge.
Svd leading(const ColumnSource& columns, int rank, const Experiment& experiment,
            const Progress& progress = {}) {
  return randomized_svd(columns,
                        {.rank = rank,
                         .oversampling = 10,
                         .max_passes = 8,
                         .tolerance = 1e-4,
                         .settled = 8,
                         .threads = experiment.threads,
                         .seed = experiment.seed},
                        progress);
}

}  // namespace

Outcome run(const Experiment& experiment, const std::function<void(double)>& progress) {
  const auto tell = [&](double share) {
    if (progress) progress(share);
  };
  const PaperColumns columns = columns_of(experiment);
  std::vector<int> classes;
  for (std::size_t j = 0; j < columns.columns(); ++j) classes.push_back(slip_class(columns.gamma(j)));
  const unsigned threads = experiment.threads;

  Outcome outcome;
  const int rank = std::min<int>(experiment.bases.back(), static_cast<int>(columns.rows()));
  std::vector<int> bases = experiment.bases;
  std::erase_if(bases, [&](int b) { return b > rank; });
  const Svd svd = leading(columns, rank, experiment, [&](double share, const char*) { tell(0.5 * share); });
  for (const double value : svd.singular_values)
    outcome.variance.push_back(value * value / svd.total_variance);
  const Split random = split_of(SplitKind::random, experiment.size, experiment.seed);
  outcome.random = accuracy_by_bases(project(columns, svd.basis, threads), classes, random, bases, threads);
  tell(0.65);

  const Split contacts = split_of(SplitKind::by_contact, experiment.size, experiment.seed);
  std::erase_if(bases, [](int b) { return b > kStrictBases; });
  const Svd strict = leading(Selected(columns, contacts.train), bases.back(), experiment);
  tell(0.8);
  outcome.by_contact =
      accuracy_by_bases(project(columns, strict.basis, threads), classes, contacts, bases, threads);
  tell(0.85);
  if (experiment.column_tests > 0) {
    outcome.random_columns = accuracy_of_columns(columns, classes, random, experiment.column_tests, threads);
    outcome.by_contact_columns =
        accuracy_of_columns(columns, classes, contacts, experiment.column_tests, threads);
  }
  tell(1);
  return outcome;
}

Eigen::MatrixXf projections(const Experiment& experiment) {
  const PaperColumns columns = columns_of(experiment);
  const Svd svd = leading(columns, 3, experiment);
  const Eigen::MatrixXf on_bases = project(columns, svd.basis, experiment.threads);
  Eigen::MatrixXf result(4, on_bases.cols());
  for (Eigen::Index k = 0; k < 3; ++k) {
    // A singular vector's sign is arbitrary: the larger projections become positive.
    const float sign = on_bases.row(k).cwiseAbs().maxCoeff() == on_bases.row(k).maxCoeff() ? 1.0F : -1.0F;
    result.row(k) = sign * on_bases.row(k);
  }
  for (Eigen::Index j = 0; j < on_bases.cols(); ++j) {
    result(3, j) = static_cast<float>(columns.gamma(static_cast<std::size_t>(j)));
  }
  return result;
}

}  // namespace lab
