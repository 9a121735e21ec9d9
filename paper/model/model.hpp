// A trained model: the SVD basis of a scene's contacts, the contacts' coordinates on it, and how far
// estimates from it were off. Made once (train.hpp), then only read, by any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

#include "core/contact/scene.hpp"
#include "core/frame/layout.hpp"
#include "core/patch/rings.hpp"
#include "core/reading/method/trained_model.hpp"
#include "core/reading/method/work_precision.hpp"
#include "paper/dataset/dataset.hpp"
#include "paper/neighbours/neighbours.hpp"

namespace slipd {

// Says which file or model, what is wrong with it and, where there is something to do, what.
class ModelError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// What the columns are: alpha of each taxel where it lies (docs/methods.md §26.1), or of rings in the
// contact's own frame.
enum class View : std::uint8_t { grid, rings };

// What a model is made from and for. Equal setups make equal models.
struct ModelSetup {
  TaxelLayout layout;
  Scene scene;
  DataSetSize size;
  std::uint64_t seed = 1;
  int rank = 8;        // bases kept; fewer where the sensor has fewer taxels
  int neighbours = 5;  // k, for the error statistics
  View view = View::grid;
  int rings = Rings::kCount;  // of View::rings: 16, or fewer that divide it

  std::size_t rows() const noexcept {
    return view == View::rings ? static_cast<std::size_t>(rings) : layout.size();
  }
  bool operator==(const ModelSetup&) const = default;
};

// Errors of estimates on contacts that were not in training, by the spread of gamma among the neighbours: in
// bin i, which reaches up to spread_to[i] (the last one without end), 68.3 % of the errors were within
// gamma[i] and friction[i].
struct ErrorStatistics {
  std::vector<float> spread_to, gamma, friction;
  float distance_limit = 0;  // to the nearest neighbour: beyond it lay 1 in 1000 of them, radians
  float residual_limit = 0;  // share of |alpha|² outside the basis: beyond it lay 1 in 1000, 0 … 1
};

struct ModelData {
  ModelSetup setup;
  double total_variance = 0;            // sum of all squared singular values, rad²
  std::vector<double> singular_values;  // rank
  std::vector<float> basis;             // rows x rank, a row's values side by side
  std::vector<float> coordinates;       // columns x rank, a column's values side by side, rad
  std::vector<float> gamma, friction;   // of each column
  ErrorStatistics errors;
  WorkPrecision work_precision;  // each method on this sensor and scene; no rows where nobody measured
};

class Model final : public TrainedModel, public std::enable_shared_from_this<Model> {
 public:
  // Throws ModelError unless all sizes fit one another and all numbers are finite and in range.
  explicit Model(ModelData data);

  const TaxelLayout& layout() const noexcept override { return data_.setup.layout; }
  const WorkPrecision& work_precision() const noexcept override { return data_.work_precision; }
  // SvdKnn in single precision.
  std::unique_ptr<SlipMethod> make_method() const override;

  const ModelSetup& setup() const noexcept { return data_.setup; }
  const ModelData& data() const noexcept { return data_; }
  std::size_t rank() const noexcept { return data_.singular_values.size(); }
  const Neighbours& neighbours() const noexcept { return neighbours_; }

  // Share of the variance that the first `bases` explain, 0 … 1.
  double explained(std::size_t bases) const noexcept;

  // 68.3 % error of gamma and friction for neighbours whose gammas spread by `spread`.
  float gamma_error(float spread) const noexcept { return data_.errors.gamma[bin_of(spread)]; }
  float friction_error(float spread) const noexcept { return data_.errors.friction[bin_of(spread)]; }

 private:
  std::size_t bin_of(float spread) const noexcept;

  ModelData data_;
  Neighbours neighbours_;
};

}  // namespace slipd
