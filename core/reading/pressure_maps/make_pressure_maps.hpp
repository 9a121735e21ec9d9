// The method `closing` of a layout under a skin, or under none.
#pragma once

#include <memory>

#include "core/contact/scene.hpp"
#include "core/frame/layout.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

// Whether there is one: under a skin on regular grids on half spaces only.
bool reads_pressure_maps(const TaxelLayout& layout, const Skin& skin) noexcept;

// It has to be there. friction_expected: as of PressureMaps.
std::unique_ptr<SlipMethod> make_pressure_maps(const TaxelLayout& layout, Range friction_expected,
                                               const Skin& skin);

}  // namespace slipd
