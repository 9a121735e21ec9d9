// slipd-camera's command line; slipd-camera(8). With --config it serves; without, it reads pictures of a file
// or a camera to frames or a view, and ends.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "bridges/support/data_folder.hpp"
#include "bridges/support/log.hpp"
#include "bridges/support/program.hpp"
#include "camera/frames/frame_writer.hpp"
#include "camera/frames/gel_reader.hpp"
#include "camera/picture/v4l2_camera.hpp"
#include "camera/picture/video_file.hpp"
#include "camera/profile/profile.hpp"
#include "camera/service/camera_service.hpp"
#include "camera/view/view.hpp"
#include "embedded/slipd_camera_schema.hpp"
#include "schema/schema.hpp"
#include "schema/settings_error.hpp"

namespace {

using namespace slipd;
using namespace slipd::camera;

constexpr int kFailed = 1;
constexpr int kWrongUse = 2;
// Of a camera, whose first pictures are dark or unsteady.
constexpr std::uint64_t kPicturesForView = 30;

struct CommandLine {
  std::string file, device, profile, frames, view;
  std::uint64_t pictures = 0;  // 0: not given
};

std::filesystem::path profile_folder() {
  return bridges::data_folder("cameras", SLIPD_INSTALLED_PROFILES);
}

std::unique_ptr<PictureSource> source_of(const CommandLine& line, const Profile& profile) {
  if (!line.file.empty()) return std::make_unique<VideoFile>(line.file, profile.picture.shrink);
  return std::make_unique<V4l2Camera>(line.device, profile.picture, profile.controls);
}

std::uint64_t most_pictures(const CommandLine& line) {
  if (line.pictures > 0) return line.pictures;
  return line.file.empty() && line.frames.empty() ? kPicturesForView
                                                  : std::numeric_limits<std::uint64_t>::max();
}

void read_pictures(const CommandLine& line) {
  const Profile profile = load_profile(line.profile, profile_folder());
  const auto source = source_of(line, profile);
  GelReader reader(profile);
  std::optional<FrameWriter> writer;
  if (!line.frames.empty()) writer.emplace(line.frames, profile.nodes, source->rate_hz());
  std::span<const float> values;
  for (std::uint64_t left = most_pictures(line); left > 0; --left) {
    const auto picture = source->next();
    if (!picture) break;
    values = reader.read(*picture);
    if (writer) writer->write(*picture, values);
  }
  if (!line.view.empty()) write_view(line.view, reader, values);
}

std::vector<Problem> problems_of_source(const nlohmann::json& settings) {
  if (settings.contains("device") != settings.contains("file")) return {};
  return {problem_of("", settings, "give either \"device\", a camera, or \"file\", a video that is played")};
}

int serve(int argc, char** argv) {
  CameraService* serving = nullptr;
  bool hears = false;
  const bridges::Program program{"slipd-camera", "Sends slipd how far the gel in front of a camera has moved",
                                 slipd_camera_schema, problems_of_source};
  return bridges::run_program(program, argc, argv, [&](const nlohmann::json& settings, bridges::Loop& loop) {
    const Profile profile = load_profile(settings["profile"], profile_folder());
    if (!std::exchange(hears, true)) loop.on_signal(SIGUSR1, [&] { serving->rest_anew(); });
    auto made = std::make_unique<CameraService>(settings, profile, loop);
    serving = made.get();
    return made;
  });
}

int read(int argc, char** argv) {
  CommandLine line;
  CLI::App app{"Sends slipd how far the gel in front of a camera has moved", "slipd-camera"};
  std::string config;
  app.add_option("--config", config,
                 "Serve with these settings (JSON with comments); --check-config checks them");
  auto* from = app.add_option_group("from");
  from->add_option("--file", line.file, "A video file");
  from->add_option("--device", line.device, "A camera, such as /dev/video0");
  from->require_option(1);
  app.add_option("--profile", line.profile, "Name of a profile, or its file")->required();
  auto* to = app.add_option_group("to");
  to->add_option("--frames", line.frames, "Where to write frames to; - is standard output");
  to->add_option("--view", line.view, "Write what is seen in the last picture to this .png or .jpg");
  to->require_option(1, 2);
  app.add_option("--pictures", line.pictures,
                 "End after so many pictures; default: of a file all, for a view of a camera 30")
      ->check(CLI::PositiveNumber);
  app.set_version_flag("--version", std::string("slipd-camera ") + SLIPD_VERSION);
  try {
    app.parse(argc, argv);
    read_pictures(line);
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kWrongUse;
  } catch (const SettingsError& error) {
    for (const std::string& problem : error.problems()) bridges::log(bridges::LogLevel::error, problem);
    return kWrongUse;
  } catch (const std::exception& error) {
    bridges::log(bridges::LogLevel::error, std::string("slipd-camera: ") + error.what());
    return kFailed;
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::span arguments(argv, static_cast<std::size_t>(argc));
  const bool serves = std::any_of(arguments.begin(), arguments.end(), [](std::string_view argument) {
    return argument == "--config" || argument.starts_with("--config=");
  });
  try {
    return serves ? serve(argc, argv) : read(argc, argv);
  } catch (const std::exception& error) {  // there was no memory to say what was wrong
    std::cerr << "slipd-camera: " << error.what() << '\n';
    return kFailed;
  }
}
