// The colours of the views. One meaning, one colour: green is safe, yellow a warning, red a slip, violet a
// simulation.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "tools/slipctl/canvas.hpp"

namespace slipctl {

inline constexpr Rgb kGreen{70, 180, 90};
inline constexpr Rgb kYellow{215, 165, 30};
inline constexpr Rgb kRed{215, 60, 50};
inline constexpr Rgb kViolet{175, 110, 215};
inline constexpr Rgb kCyan{60, 175, 200};
inline constexpr Rgb kDim{135, 135, 135};
inline constexpr Rgb kWhite{255, 255, 255};
inline constexpr Rgb kBlack{0, 0, 0};

inline constexpr Style kFaint{kDim, std::nullopt, false};

template <std::size_t N>
constexpr Rgb blend(const std::array<Rgb, N>& stops, double share) {
  const double place = std::clamp(share, 0.0, 1.0) * (N - 1);
  const std::size_t from = std::min(static_cast<std::size_t>(place), N - 2);
  const double rest = place - static_cast<double>(from);
  const auto mix = [rest](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(a + (b - a) * rest + 0.5);
  };
  const Rgb& a = stops[from];
  const Rgb& b = stops[from + 1];
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}

// Pressure as a share of the scale: dark to bright, rising in lightness, so that it reads without colour
// vision.
constexpr Rgb pressure_colour(double share) {
  return blend(
      std::array<Rgb, 5>{{{22, 18, 44}, {86, 28, 110}, {188, 55, 84}, {245, 140, 40}, {252, 250, 170}}},
      share);
}

// Traction ratio q / (mu p): blue sticks, orange slips.
constexpr Rgb traction_colour(double share) {
  return blend(std::array<Rgb, 3>{{{30, 60, 140}, {90, 130, 150}, {230, 120, 30}}}, share);
}

// Black on bright colours, white on dark ones: whichever has the greater contrast (WCAG 2.2, relative
// luminance without its gamma correction: 0.18 of linear light is about 0.46 of a display's value).
constexpr Rgb readable_on(Rgb colour) {
  return 0.2126 * colour.red + 0.7152 * colour.green + 0.0722 * colour.blue > 0.46 * 255 ? kBlack : kWhite;
}

// Absent: an unknown margin is grey.
constexpr Rgb margin_colour(std::optional<double> gamma) {
  if (!gamma) return kDim;
  return *gamma < 0.2 ? kRed : *gamma < 0.4 ? kYellow : kGreen;
}

inline Style alert_style(std::string_view alert) {
  if (alert == "slip") return {kWhite, kRed, true};
  if (alert == "warn") return {kBlack, kYellow, true};
  return {kDim, std::nullopt, false};
}

}  // namespace slipctl
