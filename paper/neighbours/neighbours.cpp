#include "paper/neighbours/neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wcast-align"
#pragma GCC diagnostic ignored "-Wnull-dereference"
#pragma GCC diagnostic ignored "-Woverloaded-virtual"
#include <flann/algorithms/dist.h>
#include <flann/algorithms/kdtree_single_index.h>
#include <flann/util/result_set.h>
#pragma GCC diagnostic pop

namespace slipd {
namespace {

using Tree = flann::KDTreeSingleIndex<flann::L2_Simple<float>>;
constexpr int kLeafSize = 16;

bool all_finite(std::span<const float> values) noexcept {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

}  // namespace

struct Neighbours::Impl {
  Impl(std::vector<float> given, std::size_t columns)
      : points(std::move(given)),
        dimensions(columns),
        size(points.size() / columns),
        tree(flann::Matrix<float>(points.data(), size, dimensions),
             flann::KDTreeSingleIndexParams(kLeafSize, /*reorder=*/true)) {
    tree.buildIndex();
  }

  std::vector<float> points;
  std::size_t dimensions;
  std::size_t size;
  Tree tree;
};

Neighbours::Neighbours(std::vector<float> points, std::size_t dimensions) {
  if (dimensions == 0 || points.empty() || points.size() % dimensions != 0) {
    throw std::invalid_argument("neighbours need at least one point, and all points of one dimension");
  }
  if (!all_finite(points)) throw std::invalid_argument("neighbours need points of finite coordinates");
  impl_ = std::make_unique<Impl>(std::move(points), dimensions);
}

Neighbours::Neighbours(Neighbours&&) noexcept = default;
Neighbours& Neighbours::operator=(Neighbours&&) noexcept = default;
Neighbours::~Neighbours() = default;
std::size_t Neighbours::size() const noexcept {
  return impl_->size;
}
std::size_t Neighbours::dimensions() const noexcept {
  return impl_->dimensions;
}

struct Neighbours::Query::Search {
  const Impl* of;
  flann::KNNSimpleResultSet<float> found;
  flann::SearchParams parameters{flann::FLANN_CHECKS_UNLIMITED, 0.0F, true};
};

Neighbours::Query::Query(const Neighbours& of, std::size_t k) {
  const std::size_t most = std::clamp<std::size_t>(k, 1, of.size());
  search_ = std::make_unique<Search>(Search{of.impl_.get(), flann::KNNSimpleResultSet<float>(most)});
  indices_.resize(most);
  squared_distances_.resize(most);
}

Neighbours::Query::Query(Query&&) noexcept = default;
Neighbours::Query& Neighbours::Query::operator=(Query&&) noexcept = default;
Neighbours::Query::~Query() = default;

std::size_t Neighbours::Query::find(std::span<const float> point) noexcept {
  if (point.size() != search_->of->dimensions || !all_finite(point)) return 0;
  search_->found.clear();
  search_->of->tree.findNeighbors(search_->found, point.data(), search_->parameters);
  search_->found.copy(indices_.data(), squared_distances_.data(), indices_.size());
  return search_->found.size();
}

}  // namespace slipd
