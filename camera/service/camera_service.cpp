#include "camera/service/camera_service.hpp"

#include <sys/epoll.h>

#include <exception>
#include <memory>
#include <stdexcept>

#include "bridges/support/log.hpp"
#include "camera/picture/played_video.hpp"
#include "camera/picture/v4l2_camera.hpp"

namespace slipd::camera {
namespace {

slipd_frames frames_of(const Profile& profile) {
  slipd_frames frames{};
  frames.taxels = static_cast<std::uint32_t>(profile.nodes.size());
  frames.axes = NodeGrid::kValues;
  frames.unit = SLIPD_UNIT_MM;
  frames.rate_hz = profile.picture.rate_hz;
  return frames;
}

PictureThread::Open opening(const nlohmann::json& settings, const Profile& profile) {
  if (settings.contains("file"))
    return [file = settings["file"].get<std::string>(), shrink = profile.picture.shrink] {
      return std::make_unique<PlayedVideo>(file, shrink);
    };
  return [device = settings["device"].get<std::string>(), wish = profile.picture,
          controls = profile.controls] { return std::make_unique<V4l2Camera>(device, wish, controls); };
}

}  // namespace

CameraService::CameraService(const nlohmann::json& settings, const Profile& profile, bridges::Loop& loop)
    : reader_(profile),
      slipd_(settings["sensor"], frames_of(profile), settings["socket"]),
      pictures_(opening(settings, profile)),
      watch_(loop, pictures_.fd(), EPOLLIN, [this](std::uint32_t) { take_news(); }) {}

void CameraService::rest_anew() {
  reader_.rest_anew();
  bridges::log(bridges::LogLevel::notice, "the next picture is rest");
}

void CameraService::take_news() {
  const PictureThread::News news = pictures_.take();
  if (!news.trouble.empty()) say(news.trouble);
  if (!news.picture) return;
  const std::uint64_t sequence = news.picture->sequence;
  sequence_ +=
      sequence > last_sequence_ ? sequence - last_sequence_ : 1;  // a camera that came back begins again
  last_sequence_ = sequence;
  try {
    if (const auto values = reader_.read(*news.picture); !values.empty()) {
      slipd_.push(values, news.picture->time_ns, sequence_);
      say({});
    }
  } catch (const std::exception& error) {
    say(error.what());
  }
}

// Each trouble once, and that it is over.
void CameraService::say(const std::string& trouble) {
  if (trouble == said_) return;
  bridges::log(trouble.empty() ? bridges::LogLevel::notice : bridges::LogLevel::warning,
               trouble.empty() ? "frames go to slipd" : trouble);
  said_ = trouble;
}

}  // namespace slipd::camera
