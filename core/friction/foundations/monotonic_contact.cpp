#include "core/friction/foundations/monotonic_contact.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/reading/moments/moments.hpp"

namespace slipd {
namespace {

constexpr std::size_t kEntries = 513, kCells = kEntries - 1;

// With Gamma = k^3 the slip moment is 5/3 (1 - k^3) - (1 - k^5).
MonotonicContact closed_form(double utilisation) noexcept {
  const double gamma = 1 - utilisation, k = std::cbrt(gamma);
  return {5.0 / 3 * utilisation - (1 - gamma * k * k), gamma_per_moment_ratio(k)};
}

std::array<MonotonicContact, kEntries> table() noexcept {
  std::array<MonotonicContact, kEntries> out;
  for (std::size_t i = 0; i < kEntries; ++i) out[i] = closed_form(static_cast<double>(i) / kCells);
  return out;
}
const std::array<MonotonicContact, kEntries> kTable = table();

}  // namespace

MonotonicContact monotonic_contact(double utilisation) noexcept {
  const double at = kCells * std::min(1.0, std::max(0.0, utilisation));
  const std::size_t cell = std::min(static_cast<std::size_t>(at), kCells - 1);
  const double share = at - static_cast<double>(cell);
  const MonotonicContact &low = kTable[cell], &high = kTable[cell + 1];
  return {low.slip_moment + share * (high.slip_moment - low.slip_moment),
          low.gamma_per_moment_ratio + share * (high.gamma_per_moment_ratio - low.gamma_per_moment_ratio)};
}

}  // namespace slipd
