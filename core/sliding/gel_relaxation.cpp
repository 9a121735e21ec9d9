#include "core/sliding/gel_relaxation.hpp"

#include <algorithm>
#include <cmath>

#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

constexpr double kNsPerSecond = 1e9;
constexpr std::size_t kLeastPictures = 2;  // one alone may be wild
constexpr double kLeastSeen = 0.5;         // share of the points below which a picture shows nothing

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
      mean_(bends_.size()),
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

// Into mean_: the bends of so many pictures, the newest of which is so many ago.
void GelRelaxation::average(std::size_t newest, std::size_t pictures) noexcept {
  const float share = 1 / static_cast<float>(pictures);
  std::ranges::fill(mean_, 0.0F);
  for (std::size_t ago = newest; ago < newest + pictures; ++ago) {
    const std::span<const float> bends = row(std::span(history_), ago);
    for (std::size_t i = 0; i < mean_.size(); ++i) mean_[i] += share * bends[i];
  }
}

// The gel rests where it was least bent.
void GelRelaxation::find_rest() noexcept {
  average(0, options_.pictures);
  const double bend_mm = length_mm(mean_, unbent_);
  if (bend_mm >= rest_bend_mm_) return;
  rest_bend_mm_ = bend_mm;
  std::ranges::copy(mean_, rest_.begin());
}

// Each picture has its part of the evidence, by which the gel is relaxed in all pictures since: a gel that
// comes to rest shows it in two of them, and a slight fall in all.
GelRelaxation::Evidence GelRelaxation::weigh() noexcept {
  const std::size_t most = options_.pictures;
  double bend_mm = 0, from_rest_mm = 0;  // the largest since
  Evidence all;
  for (std::size_t now = 1; now <= most; ++now) {
    const std::span<const float> bends = row(std::span(history_), now - 1);
    bend_mm = std::max(bend_mm, length_mm(bends, unbent_));
    from_rest_mm = std::max(from_rest_mm, length_mm(bends, rest_));
    if (now < kLeastPictures) continue;
    const std::size_t past = std::min(count_ - now, most);
    average(now, past);
    const bool held = bends_in_contact(past);
    const double nats = fall(length_mm(mean_, unbent_), bend_mm, options_.noise_mm) +
                        options_.rest_weight * fall(length_mm(mean_, rest_), from_rest_mm, options_.noise_mm);
    const double part = static_cast<double>(now) / static_cast<double>(most) * nats;
    all.nats = std::max(all.nats, part);
    all.held = all.held || held;
    all.slides = all.slides || (held && part >= options_.slides_from);
  }
  return all;
}

bool GelRelaxation::touches() const noexcept {
  return length_mm(row(std::span(history_), 0), rest_) >= options_.moved_mm;
}

// mean_, of so many pictures, and rest_ are means: their difference has this part of one picture's noise.
bool GelRelaxation::bends_in_contact(std::size_t pictures) const noexcept {
  const auto of_rest = static_cast<double>(options_.pictures), of_mean = static_cast<double>(pictures);
  return length_mm(mean_, rest_) >= options_.moved_mm * std::sqrt(1 / of_rest + 1 / of_mean);
}

void GelRelaxation::judge() noexcept {
  find_rest();
  const Evidence evidence = weigh();
  state_.evidence = evidence.nats;
  rest_seen_ = rest_seen_ || evidence.held || touches();
  if (rest_seen_) state_.contact = touches();
  if (evidence.slides) {
    state_.sliding = motion_since(count_ - 1).turns() ? Sliding::rotation : Sliding::translation;
  } else {
    const double most_mm = std::max({step_.along_mm(), step_.turning_mm, step_.stretch_mm});
    state_.sliding = most_mm >= options_.moved_mm ? Sliding::disturbed : Sliding::none;
  }
}

const GelState& GelRelaxation::update(const Frame& frame) noexcept {
  if (first_ns_ < 0) first_ns_ = frame.time_ns;
  measure(frame);
  if (frame.time_ns < last_ns_) count_ = 0;  // another clock's
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
