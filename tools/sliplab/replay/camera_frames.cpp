#include "tools/sliplab/replay/camera_frames.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <system_error>
#include <tuple>
#include <utility>

#include "drivers/push/options.hpp"

namespace sliplab {
namespace {

using slipd::DriverError;
using slipd::push_layout::FrameHead;
using slipd::push_layout::Hello;
using slipd::replay::ReadOutcome;

constexpr const char* kCamera = "slipd-camera";
constexpr int kNotFound = 127;  // of a child that could not be run

std::string camera_program() {
  std::error_code error;
  const auto beside = std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / kCamera;
  return !error && ::access(beside.c_str(), X_OK) == 0 ? beside.string() : kCamera;
}

// Starts it with its standard output on a pipe. Returns the process and the pipe's other end.
std::pair<pid_t, int> start(std::vector<std::string> words) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0)
    throw DriverError("cannot make a pipe: " + std::generic_category().message(errno));
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  pid_t child = -1;
  const int error = ::posix_spawnp(&child, arguments.front(), &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  if (error == 0) return {child, ends[0]};
  ::close(ends[0]);
  throw DriverError(std::string("cannot run ") + kCamera + ", which makes frames of a video: " +
                    std::generic_category().message(error) + "; install the package slipd-camera");
}

}  // namespace

bool is_video(const std::filesystem::path& file) {
  std::string kind = file.extension().string();
  for (char& letter : kind) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  return kind == ".avi" || kind == ".mp4" || kind == ".mkv" || kind == ".mov" || kind == ".webm";
}

CameraFrames::CameraFrames(const slipd::SensorSetup& sensor, const std::string& file)
    : file_(file),
      message_(slipd::push_layout::frame_size(sensor.layout.size(), 3)),
      reader_(std::numeric_limits<std::int64_t>::max()) {
  const std::string profile = sensor.options.value("camera_profile", std::string("own-dots"));
  std::tie(child_, pipe_) = start({camera_program(), "--file", file, "--profile", profile, "--frames", "-"});
  try {
    begin(sensor);
  } catch (...) {
    end_child();
    throw;
  }
}

CameraFrames::~CameraFrames() {
  end_child();
}

// Ends the connection, and with it the child. Returns how it ended: 0 well.
int CameraFrames::end_child() noexcept {
  if (pipe_ >= 0) ::close(pipe_);
  pipe_ = -1;
  int status = 0;
  if (child_ > 0) {
    while (::waitpid(child_, &status, 0) < 0 && errno == EINTR) continue;
  }
  child_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// Fills the beginning of message_. False: the pipe has ended.
bool CameraFrames::receive(std::size_t bytes) {
  std::size_t have = 0;
  while (have < bytes) {
    const ssize_t got = ::read(pipe_, message_.data() + have, bytes - have);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    have += static_cast<std::size_t>(got);
  }
  return true;
}

void CameraFrames::begin(const slipd::SensorSetup& sensor) {
  if (!receive(sizeof(Hello))) {
    const int how = end_child();
    throw DriverError(std::string(kCamera) + (how == kNotFound ? " cannot be run" : " makes no frames of ") +
                      file_ + ": its own message says why");
  }
  const slipd::push::Options options = slipd::push::parse_options(sensor);
  slipd::push::Text why{};
  if (!slipd::push::agree(std::span(message_).first(sizeof(Hello)), options, sensor, agreed_, why))
    throw DriverError(std::string(kCamera) + ": " + why.data());
  message_.resize(slipd::push_layout::frame_size(agreed_.taxels, agreed_.axes));
  reader_.begin(agreed_);
}

ReadOutcome CameraFrames::next(slipd::FrameSlot& out) {
  if (pipe_ < 0 || !receive(message_.size())) {
    if (child_ > 0 && end_child() != 0) fault_ = file_ + ": slipd-camera ended before the file did";
    return fault_.empty() ? ReadOutcome::end : ReadOutcome::damaged;
  }
  FrameHead head;
  std::memcpy(&head, message_.data(), sizeof head);
  const std::int64_t now_ns = std::max(head.time_ns, last_ns_ + 1);
  if (reader_.take(message_, now_ns, false, out) != slipd::push::Refusal::none) return ReadOutcome::corrupt;
  last_ns_ = out.time_ns;
  return ReadOutcome::frame;
}

}  // namespace sliplab
