#include "paper/train.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "paper/basis/svd.hpp"
#include "paper/dataset/alpha.hpp"
#include "paper/dataset/blocks.hpp"
#include "paper/dataset/frame_columns.hpp"
#include "paper/dataset/ring_columns.hpp"
#include "paper/method/knn.hpp"

namespace slipd {
namespace {

// The basis changes little with the number of columns, the time does: it is made from this many at most.
constexpr DataSetSize kBasisSize{.contacts = 320, .loads = 10};
// Contacts of their own to measure errors on.
constexpr DataSetSize kUnseen{.contacts = 800, .loads = 10};
constexpr std::size_t kErrorBins = 12;
constexpr double kWithinSigma = 0.683;
constexpr double kRare = 0.999;

Progress part(const Progress& progress, double from, double to) {
  if (!progress) return {};
  return
      [&progress, from, to](double share, const char* what) { progress(from + (to - from) * share, what); };
}

DataSetSize basis_size(const DataSetSize& size) noexcept {
  return {std::min(size.contacts, kBasisSize.contacts), std::min(size.loads, kBasisSize.loads)};
}

std::unique_ptr<ContactColumns> columns_of(const ModelSetup& setup, const FrameChoice& choice) {
  if (setup.view == View::rings)
    return std::make_unique<RingColumns>(setup.layout, setup.scene, setup.seed, choice, setup.rows());
  return std::make_unique<FrameColumns>(TaxelSet(setup.layout), setup.scene, setup.seed, choice);
}

Svd basis_of(const ModelSetup& setup, unsigned threads, const Progress& progress) {
  const SvdOptions options{.rank = setup.rank, .tolerance = 1e-5, .threads = threads, .seed = setup.seed};
  const FrameChoice choice{.size = basis_size(setup.size)};
  const bool symmetric = setup.view == View::grid && setup.scene.noise == 0 && setup.scene.offset_m == 0;
  if (const auto folded = symmetric ? fold(setup.layout) : std::nullopt) {
    const FrameColumns columns(TaxelSet(setup.layout, *folded), setup.scene, setup.seed, choice);
    Svd svd = randomized_svd(columns, options, progress);
    svd.basis = folded->unfold(svd.basis);
    return svd;
  }
  return randomized_svd(*columns_of(setup, choice), options, progress);
}

struct Projected {
  Eigen::MatrixXf coordinates;  // rank x columns
  Eigen::VectorXf squares;      // |alpha|² of each column
};

Projected project_frames(const ContactColumns& frames, const Eigen::MatrixXf& basis, unsigned threads,
                         const Progress& progress) {
  const auto columns = static_cast<Eigen::Index>(frames.columns());
  Projected result{Eigen::MatrixXf(basis.cols(), columns), Eigen::VectorXf(columns)};
  for_each_block(
      frames, threads,
      [&](const Block& block) {
        const auto first = static_cast<Eigen::Index>(block.first);
        auto part_of = result.coordinates.middleCols(first, block.values.cols());
        part_of.noalias() = basis.transpose() * block.values;
        result.squares.segment(first, block.values.cols()) = block.values.colwise().squaredNorm();
      },
      [&](double share) {
        if (progress) progress(share, "projections");
      });
  return result;
}

// The value below which `share` of them lie.
float quantile(std::vector<float> values, double share) {
  const auto at = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

struct MarginError {
  float spread, gamma, friction;
};

ErrorStatistics statistics_of(std::vector<MarginError> misses) {
  std::sort(misses.begin(), misses.end(),
            [](const MarginError& a, const MarginError& b) { return a.spread < b.spread; });
  ErrorStatistics errors;
  for (std::size_t bin = 0; bin < kErrorBins; ++bin) {
    const std::size_t from = bin * misses.size() / kErrorBins, to = (bin + 1) * misses.size() / kErrorBins;
    std::vector<float> gamma, friction;
    for (std::size_t i = from; i < to; ++i) {
      gamma.push_back(misses[i].gamma);
      friction.push_back(misses[i].friction);
    }
    errors.gamma.push_back(quantile(std::move(gamma), kWithinSigma));
    errors.friction.push_back(quantile(std::move(friction), kWithinSigma));
    if (bin + 1 < kErrorBins) errors.spread_to.push_back(misses[to - 1].spread);
  }
  return errors;
}

// Of the model's points, on contacts of their own.
ErrorStatistics measure_errors(const ModelData& data, const ContactColumns& unseen,
                               const Projected& projected) {
  const auto rank = static_cast<Eigen::Index>(data.singular_values.size());
  const Eigen::MatrixXf coordinates = projected.coordinates.topRows(rank);
  const auto width = static_cast<std::size_t>(rank);
  const Neighbours neighbours(data.coordinates, width);
  Neighbours::Query query(neighbours, searched(data.setup));
  std::vector<MarginError> misses;
  std::vector<float> distances, residuals;
  for (std::size_t j = 0; j < unseen.columns(); ++j) {
    const std::span<const float> point(coordinates.data() + j * width, width);
    const KnnResult answer = data.setup.view == View::rings
                                 ? plane_answer_of(query, point, data.coordinates, data.gamma, data.friction)
                                 : answer_of(query, point, data.gamma, data.friction);
    misses.push_back({answer.spread, std::abs(answer.gamma - static_cast<float>(unseen.gamma(j))),
                      std::abs(answer.friction - static_cast<float>(unseen.friction(j)))});
    distances.push_back(answer.distance);
    const auto column = static_cast<Eigen::Index>(j);
    residuals.push_back(residual_share(projected.squares[column], coordinates.col(column).squaredNorm()));
  }
  ErrorStatistics errors = statistics_of(std::move(misses));
  errors.distance_limit = quantile(std::move(distances), kRare);
  errors.residual_limit = quantile(std::move(residuals), kRare);
  return errors;
}

}  // namespace

ModelData train(const ModelSetup& setup, unsigned threads, const Progress& progress) {
  return std::move(train_ranks(setup, {setup.rank}, threads, progress).front());
}

std::vector<ModelData> train_ranks(ModelSetup setup, const std::vector<int>& ranks, unsigned threads,
                                   const Progress& progress) {
  if (setup.layout.size() < 2)
    throw ModelError("a single taxel shows no pattern: no model can be made for it");
  setup.rank = *std::max_element(ranks.begin(), ranks.end());
  const Svd svd = basis_of(setup, threads, part(progress, 0, 0.6));
  if (!(svd.total_variance > 0) || !(svd.singular_values.minCoeff() > 0)) {
    throw ModelError("the scene's contacts leave too little on the taxels: check layout, offset and objects");
  }
  const auto all_columns = columns_of(setup, {.size = setup.size});
  const auto unseen =
      columns_of(setup, {.first_contact = setup.size.contacts, .size = kUnseen, .random_loads = true});
  const Projected known = project_frames(*all_columns, svd.basis, threads, part(progress, 0.6, 0.85));
  const Projected test = project_frames(*unseen, svd.basis, threads, part(progress, 0.85, 1));
  // Of the whole data set, of which the basis saw a part.
  const double whole =
      static_cast<double>(setup.size.columns()) / static_cast<double>(basis_size(setup.size).columns());
  std::vector<ModelData> models;
  for (const int wanted : ranks) {
    const Eigen::Index rank = std::min<Eigen::Index>(wanted, svd.basis.cols());
    ModelData data{setup, svd.total_variance * whole, {}, {}, {}, {}, {}, {}, {}};
    data.setup.rank = wanted;
    for (Eigen::Index i = 0; i < rank; ++i)
      data.singular_values.push_back(svd.singular_values[i] * std::sqrt(whole));
    const Eigen::MatrixXf by_taxel = svd.basis.leftCols(rank).transpose();
    data.basis.assign(by_taxel.data(), by_taxel.data() + by_taxel.size());
    const Eigen::MatrixXf coordinates = known.coordinates.topRows(rank);
    data.coordinates.assign(coordinates.data(), coordinates.data() + coordinates.size());
    for (std::size_t j = 0; j < all_columns->columns(); ++j) {
      data.gamma.push_back(static_cast<float>(all_columns->gamma(j)));
      data.friction.push_back(static_cast<float>(all_columns->friction(j)));
    }
    data.errors = measure_errors(data, *unseen, test);
    models.push_back(std::move(data));
  }
  if (progress) progress(1, "done");
  return models;
}

}  // namespace slipd
