// slipd-camera's command line; slipd-camera(8).
#include <CLI/CLI.hpp>
#include <csignal>
#include <exception>
#include <filesystem>
#include <iostream>
#include <string>

#include "bridges/support/log.hpp"
#include "camera/frames/frame_writer.hpp"
#include "camera/frames/gel_reader.hpp"
#include "camera/picture/video_file.hpp"
#include "camera/profile.hpp"
#include "schema/settings_error.hpp"

namespace {

using namespace slipd;
using namespace slipd::camera;

constexpr int kFailed = 1;
constexpr int kWrongUse = 2;

struct CommandLine {
  std::string file, profile, frames;
};

// Where the profiles are: beside the sources in a build tree, installed otherwise.
std::filesystem::path profile_folder() {
  const std::filesystem::path installed = SLIPD_PROFILE_FOLDER;
  std::error_code ignored;
  return std::filesystem::is_directory(installed, ignored) ? installed : SLIPD_SOURCE_PROFILES;
}

void read_file(const CommandLine& line) {
  const Profile profile = load_profile(line.profile, profile_folder());
  VideoFile video(line.file);
  GelReader reader(profile);
  FrameWriter writer(line.frames, profile.nodes, video.rate_hz());
  while (const auto picture = video.next()) writer.write(*picture, reader.read(*picture));
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine line;
  CLI::App app{"Sends the displacement of a gel that a camera looks at to slipd", "slipd-camera"};
  app.add_option("--file", line.file, "A video file instead of the camera")->required();
  app.add_option("--profile", line.profile, "Name of a profile, or its file")->required();
  app.add_option("--frames", line.frames, "Where to write frames to; - is standard output")->required();
  app.set_version_flag("--version", std::string("slipd-camera ") + SLIPD_VERSION);
  try {
    app.parse(argc, argv);
    read_file(line);
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
