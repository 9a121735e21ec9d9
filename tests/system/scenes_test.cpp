// Each scene as shipped passes `slipd --check-config`, and plays: every sensor of it gives estimates. Where a
// scene replays a file, a file of its columns is put in its place; where a program sends the frames, a thread
// does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <thread>

#include "schema/json_text.hpp"
#include "tests/support/daemon.hpp"
#include "tests/support/push_writer.hpp"

namespace slipd::testing {
namespace {

using nlohmann::json;

std::vector<std::string> shipped_scenes() {
  std::vector<std::string> scenes;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(SLIPD_SOURCE_DIR) + "/config/scenes"))
    scenes.push_back(entry.path().stem().string());
  std::sort(scenes.begin(), scenes.end());
  return scenes;
}

json scene_of(const std::string& name) {
  std::ifstream in(std::string(SLIPD_SOURCE_DIR) + "/config/scenes/" + name + ".json");
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  json scene = parse_json_text(text);
  scene.erase("$schema");
  return scene;
}

std::size_t taxels_of(const json& layout) {
  return layout.contains("taxels")
             ? layout["taxels"].size()
             : layout["grid"][0].get<std::size_t>() * layout["grid"][1].get<std::size_t>();
}

// The taxels of all sensors that share the file, one column each, and a few rows of counts.
std::string csv_for(const json& scene, const std::string& file) {
  std::vector<std::string> names;
  for (const json& sensor : scene["sensors"]) {
    if (sensor["driver"] != "replay" || sensor["options"]["file"] != file) continue;
    if (sensor["options"].contains("taxels")) {
      for (const auto& name : sensor["options"]["taxels"]) names.push_back(name);
    } else {
      for (std::size_t k = 1; k <= taxels_of(sensor["layout"]); ++k)
        names.push_back("txl" + std::to_string(k));
    }
  }
  std::string header, row;
  for (const std::string& name : names) {
    header += (header.empty() ? "" : ",") + name + "_x," + name + "_y," + name + "_z";
    row += (row.empty() ? "" : ",") + std::string("0.1,0.2,0.3");
  }
  std::string text = header + "\n";
  for (int i = 0; i < 200; ++i) text += row + "\n";
  return text;
}

// The scene with its socket and its files in the folder.
json playable(const std::string& name, const TempFolder& folder) {
  json scene = scene_of(name);
  scene["socket"]["path"] = folder.file("s").string();
  const json shipped = scene;
  for (json& sensor : scene["sensors"]) {
    if (sensor["driver"] != "replay") continue;
    const std::string file = sensor["options"]["file"];
    sensor["options"]["file"] = folder.write(file, csv_for(shipped, file)).string();
  }
  return scene;
}

std::string name_of(const ::testing::TestParamInfo<std::string>& scene) {
  std::string name = scene.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

class Scene : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(, Scene, ::testing::ValuesIn(shipped_scenes()), name_of);

TEST_P(Scene, PassesTheCheckOfItsConfiguration) {
  const TempFolder folder;
  const json scene = playable(GetParam(), folder);
  const auto file = folder.write("scene.json", scene.dump());
  const Ran ran = run({SLIPD_BINARY_DIR "/bin/slipd", "--check-config", "--config", file.string(),
                       "--driver-dir", real_drivers().string()});
  EXPECT_EQ(ran.code, 0) << ran.errors;
}

// A program for each sensor with the driver push, until it is destroyed.
std::vector<std::jthread> programs_of(const json& scene, const TempFolder& folder) {
  std::vector<std::jthread> programs;
  for (const json& sensor : scene["sensors"]) {
    if (sensor["driver"] != "push") continue;
    const std::size_t taxels = taxels_of(sensor["layout"]);
    const bool unit_is_configured = sensor.value("options", json::object()).contains("unit");
    const auto unit = unit_is_configured ? push_layout::Unit::unsaid : push_layout::Unit::newton;
    programs.emplace_back([taxels, unit, path = folder.path() / "push" / sensor["name"].get<std::string>()](
                              const std::stop_token& stop) {
      PushWriter writer(path);
      writer.hello({.unit = unit, .taxels = static_cast<std::uint32_t>(taxels)});
      writer.answer();
      for (std::uint64_t i = 1; !stop.stop_requested(); ++i) {
        writer.push(std::vector<float>(3 * taxels), {.sequence = i});
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
    });
  }
  return programs;
}

TEST_P(Scene, PlaysEverySensor) {
  const TempFolder folder;
  const json scene = playable(GetParam(), folder);
  const Daemon daemon(scene, real_drivers());
  const std::vector<std::jthread> programs = programs_of(scene, folder);
  const json status = daemon.wait_for("status", [&](const json& s) {
    return std::all_of(s["sensors"].begin(), s["sensors"].end(),
                       [](const json& sensor) { return sensor["estimated"] > 0; });
  });
  EXPECT_EQ(status["sensors"].size(), scene["sensors"].size());
}

}  // namespace
}  // namespace slipd::testing
