// Plays files through the estimators of a scene's sensors.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/estimate/estimate.hpp"
#include "tools/offline/sweep.hpp"

namespace sliplab {

// What the chain said of one row of a file.
struct ReplayRow {
  // Time from the file's first row, s.
  double time_s = 0;
  // Number of the row, from 0.
  std::uint64_t row = 0;
  slipd::Estimate estimate;
};

// One file through one sensor of the scene, whose estimator began with it; or a grasp of such sensors.
struct ReplayRun {
  // The sensor's name, or the grasp's.
  std::string sensor;
  // Of a grasp: empty.
  std::string file;
  std::vector<ReplayRow> rows;
  // Rows whose values are all those of the row before: the device was asked more often than it measured.
  std::size_t repeated = 0;
  // Rows whose time in the file is not later than that of the row before; they are taken 1 ns after it.
  std::size_t unrisen = 0;
  // Rows a second that the file should have; none: nobody says.
  std::optional<double> wanted_rate_hz = std::nullopt;
  // Where and why the file could not be read to its end; empty: it was.
  std::string fault;
  // Its number in the sweep over files and sensors; none: the run is of a grasp.
  std::optional<std::size_t> unit = std::nullopt;
};

// Plays each file through each sensor of the scene that is called `sensor`, or through all if that is empty.
// `files` is empty for those that the scene names. As many files as sensors, with files of their own in the
// scene, belong to them in order; SENSOR=FILE names the sensor. A shard plays only some of them. Throws
// slipd::SettingsError, WrongUse or slipd::DriverError.
//
// releasing_from_s: from then on the robot lets go of the object (EstimatorChain::set_releasing), s from the
// files' first rows.
//
// After them comes a run of each grasp of the scene whose sensors have played one file each: with a row
// whenever one of them has a frame, frames of one time together.
std::vector<ReplayRun> replay(const std::filesystem::path& scene, const std::string& sensor,
                              const std::vector<std::string>& files, const offline::Shard& shard = {},
                              std::optional<double> releasing_from_s = std::nullopt);

}  // namespace sliplab
