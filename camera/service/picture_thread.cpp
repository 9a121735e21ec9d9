#include "camera/service/picture_thread.hpp"

#include <chrono>
#include <exception>
#include <utility>

namespace slipd::camera {
namespace {

constexpr std::chrono::milliseconds kBetweenAttempts{500};

}  // namespace

PictureThread::PictureThread(Open open)
    : open_(std::move(open)), thread_([this](const std::stop_token& stop) { run(stop); }) {}

PictureThread::News PictureThread::take() {
  bell_.hear();
  const std::scoped_lock lock(mutex_);
  return std::exchange(news_, {});
}

void PictureThread::tell(std::string trouble) {
  const std::scoped_lock lock(mutex_);
  news_ = {.picture = {}, .trouble = std::move(trouble)};
  bell_.ring();
}

void PictureThread::serve(const std::stop_token& stop) {
  const auto camera = open_();
  while (!stop.stop_requested()) {
    auto picture = camera->next();
    if (!picture) return;
    const std::scoped_lock lock(mutex_);
    news_.picture = std::move(picture);
    bell_.ring();
  }
}

void PictureThread::run(const std::stop_token& stop) {
  std::string told;
  while (!stop.stop_requested()) {
    try {
      serve(stop);
      if (!stop.stop_requested())
        tell("the video has ended; end this program, and start it again to play it again");
      return;
    } catch (const std::exception& error) {
      if (told != error.what()) tell(told = error.what());
    }
    std::unique_lock lock(mutex_);
    stopped_.wait_for(lock, stop, kBetweenAttempts, [] { return false; });
  }
}

}  // namespace slipd::camera
