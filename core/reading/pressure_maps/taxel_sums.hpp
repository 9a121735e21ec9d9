// Sums over taxels and over maps, for the parts of SubsurfacePressureMaps. Nothing allocates.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "core/reading/pressure_maps/recorded_maps.hpp"

namespace slipd {

using TaxelVector = Eigen::Map<Eigen::VectorXf>;
using ConstTaxelVector = Eigen::Map<const Eigen::VectorXf>;

inline TaxelVector taxel_vector(std::span<float> values) noexcept {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

inline ConstTaxelVector taxel_vector(std::span<const float> values) noexcept {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

inline double taxel_dot(std::span<const float> a, std::span<const float> b) noexcept {
  return taxel_vector(a).dot(taxel_vector(b));
}

// values += factor times a sum of maps.
inline void add_maps(std::span<float> values, double factor, const RecordedMaps& maps,
                     const Eigen::Ref<const Eigen::VectorXd>& weights,
                     RecordedMaps::Channel channel) noexcept {
  for (std::size_t map = 0; map < maps.size(); ++map)
    taxel_vector(values) += static_cast<float>(factor * weights[static_cast<Eigen::Index>(map)]) *
                            taxel_vector(maps.values(map, channel));
}

}  // namespace slipd
