// Where pictures come from. One thread's own.
#pragma once

#include <optional>

#include "camera/picture/picture.hpp"

namespace slipd::camera {

class PictureSource {
 public:
  virtual ~PictureSource() = default;
  // The next picture; waits for it. None: there are no more. Throws std::runtime_error when the source has
  // failed, or is gone.
  virtual std::optional<Picture> next() = 0;
  // Nominal rate, Hz, above 0.
  virtual double rate_hz() const noexcept = 0;
};

}  // namespace slipd::camera
