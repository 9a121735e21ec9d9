// The service: pictures of a camera or a video → frames → slipd's sensor. A picture that cannot be used is
// not sent, and slipd counts it as lost: it never sees a number that no picture gave. It runs in the loop's
// thread.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <slipd.hpp>
#include <string>

#include "bridges/support/loop.hpp"
#include "bridges/support/program.hpp"
#include "camera/frames/gel_reader.hpp"
#include "camera/profile/profile.hpp"
#include "camera/service/picture_thread.hpp"

namespace slipd::camera {

class CameraService final : public bridges::Service {
 public:
  // Settings that fit camera.schema.json. Neither camera nor slipd need be there. Throws client::Error for
  // frames that no sensor has.
  CameraService(const nlohmann::json& settings, const Profile& profile, bridges::Loop& loop);

  // The next usable picture is rest.
  void rest_anew();

 private:
  void take_news();
  void say(const std::string& trouble);

  GelReader reader_;
  client::Source slipd_;
  std::uint64_t last_sequence_ = 0, sequence_ = 0;
  std::string said_ = "nothing yet";  // the last trouble
  PictureThread pictures_;
  bridges::Loop::Watch watch_;
};

}  // namespace slipd::camera
