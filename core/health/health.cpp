#include "core/health/health.hpp"

#include <array>

namespace slipd {
namespace {

struct HealthText {
  std::string_view name;
  const char* description;
};

constexpr std::array<HealthText, kHealths> kHealthTexts{{
    {"good", "plausible"},
    {"not_finite", "implausible: values are not numbers"},
    {"full_scale", "implausible: taxels beyond full scale"},
    {"spike", "implausible: a taxel that no neighbour supports is left out"},
    {"uniform", "implausible: all taxels read the same pressure"},
    {"wrong_scale", "implausible: the force does not fit the size of the contact"},
    {"saturated", "implausible: taxels are saturated"},
    {"repeated", "implausible: the frame repeats the one before"},
    {"frozen", "implausible: frames are frozen"},
    {"dead_normal", "implausible: the normal channel is dead"},
    {"dead_shear_x", "implausible: shear x is dead"},
    {"dead_shear_y", "implausible: shear y is dead"},
    {"dead_row", "implausible: a row or column of taxels is dead"},
    {"time", "implausible: the time does not rise"},
    {"jump", "implausible: the contact or all pressures have jumped"},
    {"unexplained", "implausible: frames fit no contact, and the forces do not say why"},
    {"noisy", "implausible: a channel has become noisy"},
}};

}  // namespace

std::string_view to_string(Health health) noexcept {
  const auto i = static_cast<std::size_t>(health);
  return i < kHealths ? kHealthTexts[i].name : "unknown";
}

const char* describe(Health health) noexcept {
  const auto i = static_cast<std::size_t>(health);
  return i < kHealths ? kHealthTexts[i].description : "there is no frame that could be checked";
}

}  // namespace slipd
