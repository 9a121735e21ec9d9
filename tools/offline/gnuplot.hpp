// Plots with gnuplot from data files in the same folder.
#pragma once

#include <filesystem>
#include <string>

namespace offline {

// Writes `text`; throws std::runtime_error with the file's name.
void write_file(const std::filesystem::path& file, const std::string& text);

// Writes `script` as NAME.gp into `folder` and runs gnuplot on it there. Throws std::runtime_error if gnuplot
// is not installed or fails.
void plot(const std::filesystem::path& folder, const std::string& name, const std::string& script);

}  // namespace offline
