#include "core/sliding/gel_relaxation.hpp"

#include <algorithm>
#include <cmath>

#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

constexpr double kNsPerSecond = 1e9;
constexpr double kLeastSeen = 0.5;  // share of the points below which a picture shows nothing

double length_mm(std::span<const float> bends, std::span<const float> from) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < bends.size(); ++i) {
    const double bend = static_cast<double>(bends[i] - from[i]);
    sum += bend * bend;
  }
  return std::sqrt(sum / static_cast<double>(bends.size()));
}

double fall(double past, double now, double noise) noexcept {
  return std::log(norm(past, noise) / norm(now, noise));
}

}  // namespace

GelRelaxation::GelRelaxation(const TaxelLayout& layout, const GelRelaxationOptions& options)
    : layout_(layout),
      options_(options),
      kept_(2 * options.pictures),
      bends_(layout),
      history_(kept_ * bends_.size()),
      fields_(kept_ * 2 * layout.size()),
      now_(bends_.size()),
      past_(bends_.size()),
      rest_(bends_.size()),
      unbent_(bends_.size()),
      change_(2 * layout.size()) {}

void GelRelaxation::set_releasing(bool releasing) noexcept {
  if (releasing_ && !releasing) count_ = 0;
  releasing_ = releasing;
}

template <typename Value>
std::span<Value> GelRelaxation::row(std::span<Value> ring, std::size_t ago) const noexcept {
  const std::size_t width = ring.size() / kept_;
  return ring.subspan((newest_ + kept_ - ago) % kept_ * width, width);
}

RigidMotion GelRelaxation::motion_since(std::size_t ago) const noexcept {
  const std::span<const float> now = row(std::span(fields_), 0), then = row(std::span(fields_), ago);
  for (std::size_t i = 0; i < now.size(); ++i) change_[i] = now[i] - then[i];
  const std::span<const float> change(change_);
  return rigid_motion(layout_, change.first(layout_.size()), change.last(layout_.size()));
}

void GelRelaxation::measure(const Frame& frame) noexcept {
  double sum = 0, seen = 0;
  for (std::size_t i = 0; i < layout_.size(); ++i) {
    const double x = static_cast<double>(frame.shear_x_pa[i]), y = static_cast<double>(frame.shear_y_pa[i]);
    if (!std::isfinite(x) || !std::isfinite(y)) continue;
    sum += x * x + y * y;
    seen += 1;
  }
  state_.displacement_mm.reset();
  if (seen >= kLeastSeen * static_cast<double>(layout_.size()))
    state_.displacement_mm = std::sqrt(sum / seen);
}

// Puts the picture into the ring.
void GelRelaxation::take(const Frame& frame) noexcept {
  newest_ = (newest_ + 1) % kept_;
  const std::span<const float> bends = bends_.update(frame);
  std::ranges::copy(bends, row(std::span(history_), 0).begin());
  const std::span<float> field = row(std::span(fields_), 0);
  std::ranges::copy(frame.shear_x_pa, field.begin());
  std::ranges::copy(frame.shear_y_pa, field.begin() + static_cast<std::ptrdiff_t>(layout_.size()));
  count_ = std::min(count_ + 1, kept_);
}

// A camera that starts gives pictures from before, and then those of now.
bool GelRelaxation::is_stale_jump(std::int64_t time_ns, double step_mm) const noexcept {
  const double since_s = static_cast<double>(time_ns - first_ns_) / kNsPerSecond;
  return since_s <= options_.settling_s && step_mm > kClearSigmas * options_.moved_mm &&
         last_step_mm_ < options_.moved_mm;
}

// Mean bends now and in the past, and the rest: where the gel was least bent for as long as now_ is.
void GelRelaxation::average() noexcept {
  const std::size_t now = options_.pictures, past = count_ - now;
  std::ranges::fill(now_, 0.0F);
  std::ranges::fill(past_, 0.0F);
  for (std::size_t ago = 0; ago < count_; ++ago) {
    const std::span<const float> bends = row(std::span(history_), ago);
    std::vector<float>& mean = ago < now ? now_ : past_;
    const float share = 1 / static_cast<float>(ago < now ? now : past);
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += share * bends[i];
  }
  const double bend_mm = length_mm(now_, unbent_);
  if (begun_ && bend_mm >= rest_bend_mm_) return;
  begun_ = true;
  rest_bend_mm_ = bend_mm;
  std::ranges::copy(now_, rest_.begin());
}

// The largest bend of the pictures that are now.
double GelRelaxation::most_now_mm(std::span<const float> from) const noexcept {
  double most = 0;
  for (std::size_t ago = 0; ago < options_.pictures; ++ago)
    most = std::max(most, length_mm(row(std::span(history_), ago), from));
  return most;
}

double GelRelaxation::weigh() const noexcept {
  const double bend = fall(length_mm(past_, unbent_), most_now_mm(unbent_), options_.noise_mm);
  const double to_rest = fall(length_mm(past_, rest_), most_now_mm(rest_), options_.noise_mm);
  return std::max(0.0, bend + options_.rest_weight * to_rest);
}

bool GelRelaxation::touches() const noexcept {
  return length_mm(row(std::span(history_), 0), rest_) >= options_.moved_mm;
}

// past_ and rest_ are means: their difference has this part of one picture's noise.
bool GelRelaxation::was_held() const noexcept {
  const auto now = static_cast<double>(options_.pictures), past = static_cast<double>(count_) - now;
  return length_mm(past_, rest_) >= options_.moved_mm * std::sqrt(1 / now + 1 / past);
}

void GelRelaxation::judge() noexcept {
  average();
  const bool held = was_held();
  rest_seen_ = rest_seen_ || held || touches();
  if (rest_seen_) state_.contact = touches();
  state_.evidence = weigh();
  if (held && state_.evidence >= options_.slides_from) {
    state_.sliding = motion_since(count_ - 1).turns() ? Sliding::rotation : Sliding::translation;
  } else {
    const double most_mm = std::max({step_.along_mm(), step_.turning_mm, step_.stretch_mm});
    state_.sliding = most_mm >= options_.moved_mm ? Sliding::disturbed : Sliding::none;
  }
}

const GelState& GelRelaxation::update(const Frame& frame) noexcept {
  if (first_ns_ < 0) first_ns_ = frame.time_ns;
  measure(frame);
  if (count_ > 0 && static_cast<double>(frame.time_ns - last_ns_) < options_.least_step_s * kNsPerSecond)
    return state_;
  last_ns_ = frame.time_ns;
  state_.contact.reset();
  state_.sliding.reset();
  state_.evidence = 0;
  if (!state_.displacement_mm) return state_;
  take(frame);
  if (count_ > 1) {
    step_ = motion_since(1);
    const double step_mm = std::hypot(step_.along_mm(), step_.turning_mm, step_.stretch_mm);
    if (is_stale_jump(frame.time_ns, step_mm)) count_ = 1;
    last_step_mm_ = step_mm;
  }
  if (releasing_) {
    if (rest_seen_) state_.contact = touches();
  } else if (count_ >= options_.pictures + options_.least_past()) {
    judge();
  }
  return state_;
}

}  // namespace slipd
