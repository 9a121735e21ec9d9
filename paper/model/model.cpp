#include "paper/model/model.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace slipd {
namespace {

template <typename T>
void check_list(const char* name, const std::vector<T>& list, std::size_t size, double low, double high) {
  if (list.size() != size) {
    throw ModelError(std::string("the model's ") + name + " are " + std::to_string(list.size()) + ", not " +
                     std::to_string(size));
  }
  for (const T value : list) {
    if (!(value >= low && value <= high)) {
      throw ModelError(std::string("the model's ") + name + " hold " + std::to_string(value) +
                       ", which is outside " + std::to_string(low) + " to " + std::to_string(high));
    }
  }
}

ModelData checked(ModelData data) {
  constexpr double kHuge = 1e30;
  const std::size_t rank = data.singular_values.size(), columns = data.setup.size.columns();
  if (rank == 0 || columns == 0) throw ModelError("the model is empty");
  if (!(data.total_variance > 0 && data.total_variance < kHuge))
    throw ModelError("the model holds no variance");
  check_list("singular values", data.singular_values, rank, 0, kHuge);
  check_list("basis values", data.basis, data.setup.rows() * rank, -2, 2);
  check_list("coordinates", data.coordinates, columns * rank, -kHuge, kHuge);
  check_list("margins", data.gamma, columns, 0, 1);
  check_list("frictions", data.friction, columns, 0, kHuge);
  const auto& errors = data.errors;
  const std::size_t bins = errors.gamma.size();
  if (bins == 0) throw ModelError("the model does not know its errors");
  check_list("error bins", errors.spread_to, bins - 1, 0, kHuge);
  if (!std::is_sorted(errors.spread_to.begin(), errors.spread_to.end())) {
    throw ModelError("the model's error bins are not in order");
  }
  check_list("errors of the margin", errors.gamma, bins, 0, kHuge);
  check_list("errors of friction", errors.friction, bins, 0, kHuge);
  if (!(errors.distance_limit >= 0) || !(errors.residual_limit >= 0))
    throw ModelError("the model has no limits");
  return data;
}

}  // namespace

Model::Model(ModelData data) : data_(checked(std::move(data))), neighbours_(data_.coordinates, rank()) {}

double Model::explained(std::size_t bases) const noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < std::min(bases, rank()); ++i)
    sum += data_.singular_values[i] * data_.singular_values[i];
  return sum / data_.total_variance;
}

std::size_t Model::bin_of(float spread) const noexcept {
  const auto& to = data_.errors.spread_to;
  return static_cast<std::size_t>(std::lower_bound(to.begin(), to.end(), spread) - to.begin());
}

}  // namespace slipd
