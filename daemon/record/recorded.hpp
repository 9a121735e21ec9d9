// From an estimate to what a recording keeps of it: all that clients are told. Any thread; allocates nothing.
#pragma once

#include "core/estimate/estimate.hpp"
#include "core/recording/recorded_estimate.hpp"

namespace slipd {

RecordedEstimate recorded(const Estimate& estimate) noexcept;

}  // namespace slipd
