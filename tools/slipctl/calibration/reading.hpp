// What a sensor reads while nothing moves: mean forces of some seconds, and how still they were. Any thread.
#pragma once

#include <array>
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <span>

namespace slipctl::calibration {

// Indices of a Reading's forces.
inline constexpr std::size_t kX = 0, kY = 1, kNormal = 2;

// Sums over the taxels of one frame.
struct FrameSums {
  std::array<double, 3> force_n{};     // shear along x, along y, normal force; N
  std::array<double, 2> moment_nmm{};  // normal force times position, along x and y; N mm
};

// Their course over some seconds.
struct Reading {
  std::array<double, 3> force_n{};     // means, as in FrameSums
  std::array<double, 3> sigma_n{};     // standard deviations of these means
  std::array<double, 3> range_n{};     // between the least and the greatest mean of a tenth of the time
  std::array<double, 3> chance_n{};    // up to which range_n is noise of frames
  std::array<double, 2> moment_nmm{};  // means
  std::size_t frames = 0;
};

// Fewer frames say nothing of stillness.
inline constexpr std::size_t kLeastFrames = 20;

// At least kLeastFrames frames, in their order. Throws std::invalid_argument for fewer.
Reading reading_of(std::span<const FrameSums> frames);

// For files between two steps. from_json throws nlohmann::json::exception for what is none.
nlohmann::json to_json(const Reading& reading);
Reading reading_from(const nlohmann::json& json);

}  // namespace slipctl::calibration
