// The matrices X_p, X_q and X_alpha of docs/methods.md §26.1: the contact model at each taxel's middle, noise
// on the quantity itself. For reproducing published figures; what a sensor measures is frame_columns.hpp.
#pragma once

#include "core/contact/scene.hpp"
#include "paper/dataset/column_source.hpp"
#include "paper/dataset/dataset.hpp"
#include "paper/dataset/taxel_set.hpp"

namespace slipd {

enum class Quantity : std::uint8_t { pressure, shear, alpha };

class PaperColumns final : public ColumnSource {
 public:
  // Column j is contact j / loads at load step j % loads of the scene's contacts by `seed`, in Pa or rad.
  // Noise: uniform within the scene's fraction of the column's largest value. Throws std::invalid_argument
  // for a noisy scene on folded taxels, and ContactError for a scene with contacts that Hertz does not cover.
  PaperColumns(TaxelSet taxels, Scene scene, DataSetSize size, std::uint64_t seed, Quantity quantity);

  std::size_t rows() const noexcept override { return taxels_.size(); }
  std::size_t columns() const noexcept override { return size_.columns(); }
  void fill(std::size_t first, std::size_t count, float* out) const override;

  double gamma(std::size_t column) const noexcept { return gamma_of_step(column % size_.loads, size_.loads); }
  std::size_t contact(std::size_t column) const noexcept { return column / size_.loads; }

 private:
  TaxelSet taxels_;
  Scene scene_;
  DataSetSize size_;
  std::uint64_t seed_;
  Quantity quantity_;
};

}  // namespace slipd
