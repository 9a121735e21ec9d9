#include "camera/profile/profile.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "bridges/support/settings_file.hpp"
#include "embedded/slipd_camera_profile_schema.hpp"
#include "schema/json_text.hpp"
#include "schema/schema.hpp"
#include "schema/settings_error.hpp"

namespace slipd::camera {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

// Rules that the schema cannot state.
std::vector<Problem> further_problems(const json& profile) {
  const json& surface = profile["surface"];
  std::vector<Problem> problems;
  if (!surface.contains("mm_per_px") && (!surface.contains("pitch_mm") || surface["follow"] != "dots"))
    problems.push_back(
        problem_of("/surface", surface, "the scale is missing: give mm_per_px, or of dots their pitch_mm"));
  return problems;
}

std::string names_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list.empty() ? "none" : list;
}

PictureFormat format_of(const std::string& word) {
  if (word == "yuyv") return PictureFormat::yuyv;
  return word == "grey" ? PictureFormat::grey : PictureFormat::mjpeg;
}

PictureWish picture_of(const json& from) {
  PictureWish wish{.width = from["width"],
                   .height = from["height"],
                   .format = format_of(from["format"]),
                   .rate_hz = from["rate_hz"],
                   .shrink = from["shrink"],
                   .crop = {}};
  if (const auto crop = from.find("crop"); crop != from.end())
    wish.crop = cv::Rect((*crop)[0], (*crop)[1], (*crop)[2], (*crop)[3]);
  return wish;
}

SurfaceFacts surface_of(const json& from) {
  return {.texture = from["follow"] == "texture",
          .bright = from["bright"],
          .radius_px = from.value("radius_px", 0.0),
          .pitch_mm = from.value("pitch_mm", 0.0),
          .mm_per_px = from.value("mm_per_px", 0.0),
          .bend = from["bend"]};
}

}  // namespace

Profile load_profile(const std::string& name_or_path, const fs::path& folder) {
  const bool is_path = name_or_path.find('/') != std::string::npos || name_or_path.ends_with(".json");
  const fs::path file = is_path ? fs::path(name_or_path) : folder / (name_or_path + ".json");
  std::error_code ignored;
  if (!is_path && !fs::exists(file, ignored))
    throw SettingsError({"no profile \"" + plain(name_or_path) + "\" in " + folder.string() + ": there are " +
                         names_in(folder) + "; give one of them, or the path of a file"});
  const json profile = bridges::load_settings(file, slipd_camera_profile_schema, further_problems);
  const json& nodes = profile["nodes"];
  return {.picture = picture_of(profile["picture"]),
          .controls = profile["controls"],
          .surface = surface_of(profile["surface"]),
          .nodes = {nodes["rows"], nodes["columns"], nodes["pitch_mm"]}};
}

}  // namespace slipd::camera
