// The thread that takes pictures: it opens the camera, waits for pictures, decodes them, and keeps the newest
// for the loop. A camera that fails or is gone is opened anew, twice a second; a video ends once.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include "bridges/support/bell.hpp"
#include "camera/picture/picture_source.hpp"

namespace slipd::camera {

class PictureThread {
 public:
  // Opens the camera; throws std::runtime_error. Called in the picture thread.
  using Open = std::function<std::unique_ptr<PictureSource>()>;

  // For the loop.
  struct News {
    std::optional<Picture> picture;
    // Why there are no pictures; once for each time that they end. Empty: they come.
    std::string trouble;
  };

  explicit PictureThread(Open open);

  // Readable when there is news.
  int fd() const noexcept { return bell_.fd(); }
  // The loop's thread. What has come since the last call; only the newest picture.
  News take();

 private:
  void run(const std::stop_token& stop);
  void serve(const std::stop_token& stop);
  void tell(std::string trouble);

  Open open_;
  bridges::Bell bell_;
  std::mutex mutex_;
  std::condition_variable_any stopped_;
  News news_;            // of mutex_
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace slipd::camera
