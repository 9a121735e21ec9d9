#include "core/estimate/estimate.hpp"

#include <array>

namespace slipd {
namespace {

template <std::size_t N, typename Enum>
std::string_view name_of(const std::array<std::string_view, N>& names, Enum value) noexcept {
  const auto i = static_cast<std::size_t>(value);
  // cppcheck-suppress returnDanglingLifetime ; the names are literals
  return i < N ? names[i] : "unknown";
}

}  // namespace

std::string_view to_string(State state) noexcept {
  static constexpr std::array<std::string_view, 8> kNames{
      "ok", "no_contact", "learning", "out_of_model", "no_shear", "unzeroed", "stale", "fault"};
  return name_of(kNames, state);
}

std::string_view to_string(Alert alert) noexcept {
  static constexpr std::array<std::string_view, 4> kNames{"none", "warn", "slip", "unknown"};
  return name_of(kNames, alert);
}

std::string_view to_string(AlertCause cause) noexcept {
  static constexpr std::array<std::string_view, 3> kNames{"none", "margin", "sliding"};
  return name_of(kNames, cause);
}

std::string_view to_string(Method method) noexcept {
  static constexpr std::array<std::string_view, 9> kNames{
      "none", "svd-knn", "registered", "moments", "fit", "friction", "closing", "block-fit", "displacement"};
  return name_of(kNames, method);
}

}  // namespace slipd
