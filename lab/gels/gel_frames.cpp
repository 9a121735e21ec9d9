#include "lab/gels/gel_frames.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lab/frames/draws.hpp"

namespace lab {

using namespace slipd;

namespace {

constexpr double kNsPerSecond = 1e9;
constexpr double kRest_s = 1, kHeld_s = 60;

// Loads one after the other.
class Script {
 public:
  explicit Script(GelGrasp& grasp) : grasp_(grasp) {}
  double now_s() const { return grasp_.loads.empty() ? 0 : grasp_.loads.back().time_s; }
  void to(double seconds, double normal_n, double share) {
    grasp_.loads.push_back({now_s() + seconds, normal_n, share});
  }
  void hold(double seconds) { to(seconds, grasp_.loads.back().normal_n, grasp_.loads.back().share); }

 private:
  GelGrasp& grasp_;
};

// Slip begins, with nothing left of the margin.
void slide(GelGrasp& grasp, Script& script, Draws& draws, double normal_n) {
  script.to(draws.uniform(0.1, 1), normal_n, 1);
  grasp.slides_s = script.now_s();
  grasp.kinetic = draws.uniform(0.6, 1);
}

void slide_and_stop(GelGrasp& grasp, Script& script, Draws& draws, double normal_n) {
  slide(grasp, script, draws, normal_n);
  const double speed_m_per_s = draws.uniform(0.005, 0.05);
  if (grasp.course == GelCourse::rolls) grasp.contact_m_per_s = speed_m_per_s;
  script.hold(std::min(draws.uniform(0.2, 1), 0.01 / speed_m_per_s));
  grasp.stops_s = script.now_s();
  script.to(draws.uniform(0.1, 0.3), normal_n, draws.uniform(0.4, 0.7));
  script.hold(3);
}

// When its end has come to the contact, the contact is left over its width.
void slide_away(GelGrasp& grasp, Script& script, Draws& draws, double normal_n) {
  slide(grasp, script, draws, normal_n);
  const double faster_m_per_s2 = draws.uniform(0.5, 8);
  const double width_m = 2 * grasp.pair.contact_radius_m(normal_n), way_m = draws.uniform(0.002, 0.02);
  const double end_s = std::sqrt(2 * way_m / faster_m_per_s2);
  script.hold(end_s);
  script.to(std::sqrt(2 * (way_m + width_m) / faster_m_per_s2) - end_s, 0, 1);
  grasp.lost_s = script.now_s();
  script.to(2, 0, 1);
}

void change_loads(Script& script, Draws& draws, double normal_n) {
  const double until_s = script.now_s() + kHeld_s;
  while (script.now_s() < until_s) {
    script.to(draws.uniform(0.1, 0.5), normal_n, draws.uniform(0.2, 0.8));
    script.hold(draws.uniform(1, 4));
  }
}

}  // namespace

const char* name_of(GelCourse course) noexcept {
  static constexpr const char* kNames[] = {"held",     "shaken", "loaded", "eased",
                                           "set down", "drags",  "rolls",  "falls"};
  return kNames[static_cast<std::size_t>(course)];
}

GelGrasp draw_gel_grasp(GelCourse course, const RandomStream& random) {
  constexpr double kHard_pa = 1e9, kOff_m = 0.002;
  Draws draws(random);
  GelGrasp grasp;
  grasp.course = course;
  grasp.pair = contact::make_body_pair(
      {std::numeric_limits<double>::infinity(), GelFrames::kModulus_pa, GelFrames::kPoisson},
      {draws.uniform(0.008, 0.02), kHard_pa, 0.3});
  grasp.friction = draws.uniform(0.3, 1);
  grasp.toward_rad = draws.uniform(0, 2 * std::numbers::pi);
  grasp.x_m = draws.uniform(-kOff_m, kOff_m);
  grasp.y_m = draws.uniform(-kOff_m, kOff_m);
  const double normal_n = draws.uniform(1, 5), lifted = draws.uniform(0.3, 0.7);
  grasp.tremor_hz = draws.uniform(0.5, 8);
  Script script(grasp);
  script.to(0, 0, 0);
  script.hold(kRest_s);
  script.to(draws.uniform(0.1, 0.5), normal_n, 0);
  script.hold(draws.uniform(0.2, 1));
  script.to(draws.uniform(0.1, 0.5), normal_n, lifted);
  script.hold(draws.uniform(1, 3));
  switch (course) {
    case GelCourse::held:
      grasp.tremor = draws.uniform(0, 0.15);
      script.hold(kHeld_s);
      break;
    case GelCourse::shaken:
      script.to(0.5, normal_n, 0.5);
      grasp.tremor = draws.uniform(0.15, 0.45);
      script.hold(kHeld_s);
      break;
    case GelCourse::loaded:
      change_loads(script, draws, normal_n);
      break;
    case GelCourse::eased: {
      const double eased = draws.uniform(0.6, 0.9);
      script.to(draws.uniform(0.2, 1), eased * normal_n, std::min(0.9, lifted / eased));
      script.hold(3);
      break;
    }
    case GelCourse::set_down:
      script.to(draws.uniform(0.2, 1), normal_n, 0);
      script.hold(3);
      break;
    case GelCourse::drags:
    case GelCourse::rolls:
      slide_and_stop(grasp, script, draws, normal_n);
      break;
    case GelCourse::falls:
      slide_away(grasp, script, draws, normal_n);
      break;
  }
  return grasp;
}

GelFrames::GelFrames(const GelGrasp& grasp, const GelSurface& surface, const TaxelLayout& layout,
                     double rate_hz, double noise_m, const RandomStream& random)
    : grasp_(grasp),
      surface_(surface),
      layout_(layout),
      rate_hz_(rate_hz),
      noise_m_(noise_m),
      random_(random),
      history_(grasp.pair),
      values_(3 * layout.size()) {
  const std::span<float> all(values_);
  slot_.normal_pa = all.first(layout.size());
  slot_.shear_x_pa = all.subspan(layout.size(), layout.size());
  slot_.shear_y_pa = all.last(layout.size());
}

GelGrasp::Load GelFrames::load_at(double time_s) const noexcept {
  const auto after = std::ranges::upper_bound(grasp_.loads, time_s, {}, &GelGrasp::Load::time_s);
  if (after == grasp_.loads.begin() || after == grasp_.loads.end()) return {};
  const auto before = after - 1;
  const double part = (time_s - before->time_s) / (after->time_s - before->time_s);
  return {time_s, std::lerp(before->normal_n, after->normal_n, part),
          std::lerp(before->share, after->share, part)};
}

double GelFrames::travelled_m(double time_s) const noexcept {
  return grasp_.contact_m_per_s * std::max(0.0, std::min(time_s, grasp_.stops_s) - grasp_.slides_s);
}

bool GelFrames::next() {
  const double time_s = static_cast<double>(moment_.number) / rate_hz_;
  if (time_s >= grasp_.loads.back().time_s) return false;
  ++moment_.number;
  moment_.time_s = time_s;
  const GelGrasp::Load load = load_at(time_s);
  const bool slides = time_s >= grasp_.slides_s && time_s < grasp_.stops_s;
  double share = load.share;
  if (share > 0 && !slides)
    share += grasp_.tremor * std::sin(2 * std::numbers::pi * grasp_.tremor_hz * time_s);
  const double friction = grasp_.friction * (slides ? grasp_.kinetic : 1);
  const double beyond = slides ? 2 : 1;  // what friction cannot hold
  history_.move_to(load.normal_n, beyond * share * friction * load.normal_n, friction);
  moment_.normal_n = load.normal_n;
  moment_.shear_n = history_.shear_n();
  moment_.truth = {history_.safety_margin(), friction};
  return true;
}

GelFrames::Moved GelFrames::moved(double x_m, double y_m) const noexcept {
  constexpr double kShear_pa = kModulus_pa / (2 * (1 + kPoisson));
  const double cos = std::cos(grasp_.toward_rad), sin = std::sin(grasp_.toward_rad);
  const double travelled = travelled_m(moment_.time_s);
  const double x = x_m - grasp_.x_m - travelled * cos, y = y_m - grasp_.y_m - travelled * sin;
  const double along = x * cos + y * sin, across = y * cos - x * sin, r = std::hypot(x, y);
  const double scale = grasp_.pair.disc_scale_pa_per_m() / kShear_pa;
  GelSurface::Moved moved;
  for (const contact::DiscTerm& disc : history_.shear_terms()) {
    const GelSurface::Moved by = surface_.dragged(disc.radius_m, along, across);
    moved.along_m += scale * disc.radius_m * disc.coefficient * by.along_m;
    moved.across_m += scale * disc.radius_m * disc.coefficient * by.across_m;
  }
  const double radius = history_.contact_radius_m();
  if (radius > 0 && r > 0) {
    const double outwards = scale * radius * surface_.pressed(radius, r) / r;
    moved.along_m += outwards * along;
    moved.across_m += outwards * across;
  }
  return {moved.along_m * cos - moved.across_m * sin, moved.along_m * sin + moved.across_m * cos};
}

FrameSlot& GelFrames::sense() {
  constexpr double kPerM = 1e3, kUniform = std::numbers::sqrt3;
  slot_.sequence = moment_.number;
  slot_.time_ns = std::llround(kNsPerSecond * moment_.time_s);
  slot_.truth = moment_.truth;
  for (std::size_t i = 0; i < layout_.size(); ++i) {
    const Moved at = moved(layout_.x_m()[i], layout_.y_m()[i]);
    slot_.shear_x_pa[i] = static_cast<float>(kPerM * at.x_m);
    slot_.shear_y_pa[i] = static_cast<float>(kPerM * at.y_m);
  }
  const auto half_mm = static_cast<float>(kUniform * kPerM * noise_m_);
  random_.stream(moment_.number).add_noise(slot_.shear_x_pa.data(), 2 * layout_.size(), half_mm);
  return slot_;
}

}  // namespace lab
