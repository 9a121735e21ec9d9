// Pressure maps beside another method, for frames that its contact model does not fit: the better of both
// reads a frame. A contact of the model's shape that the method refuses has another history, of which maps
// show no more. Estimate thread; allocates in its constructor only.
#pragma once

#include <memory>

#include "core/frame/layout.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

class MapsBesideMethod : public SlipMethod {
 public:
  // Both not null.
  MapsBesideMethod(std::unique_ptr<SlipMethod> method, std::unique_ptr<SlipMethod> maps)
      : method_(std::move(method)), maps_(std::move(maps)) {}

  Method name() const noexcept override { return method_->name(); }
  MethodSettings settings() const noexcept override { return method_->settings(); }
  void observe(const Frame& frame, const ContactPatch& patch) noexcept override;
  void forget() noexcept override;

 protected:
  Reading read_by_method(const Frame& frame, const ContactPatch& patch) noexcept;
  Reading read_by_maps(const Frame& frame, const ContactPatch& patch) noexcept;
  // `by_maps`, with the moments of `by_method` where it has none of its own.
  static Reading take_maps(Reading by_maps, const Reading& by_method) noexcept;
  static Reading take_method(const Reading& by_maps, Reading by_method) noexcept;

 private:
  std::unique_ptr<SlipMethod> method_, maps_;
};

// At the surface: pressure shows how far a contact is from Hertz's.
class MapsAtSurface final : public MapsBesideMethod {
 public:
  MapsAtSurface(const TaxelLayout& layout, std::unique_ptr<SlipMethod> method,
                std::unique_ptr<SlipMethod> maps)
      : MapsBesideMethod(std::move(method), std::move(maps)), layout_(layout) {}
  Reading estimate(const Frame& frame, const ContactPatch& patch) noexcept override;

 private:
  const TaxelLayout layout_;
};

// Under a skin, which hides most of another shape: the fit compares them (Reading::shape_sigma).
class MapsUnderSkin final : public MapsBesideMethod {
 public:
  using MapsBesideMethod::MapsBesideMethod;
  Reading estimate(const Frame& frame, const ContactPatch& patch) noexcept override;
};

}  // namespace slipd
