#include "camera/surface/dot_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slipd::camera {
namespace {

// Neighbours that are asked where a dot has gone.
constexpr std::size_t kNeighbours = 8;
// Neighbours are at most this far away, spacings.
constexpr float kNeighbourhood = 2.2F;
// Nearer to a known point than this, spacings, no dot is a new one.
constexpr float kApart = 0.45F;
// A point that differs from most neighbours by more than this, spacings, has become another dot.
constexpr float kStray = 0.5F;
// A dot this near to where a point rests, spacings, may be that point at rest. By chance one in fourteen is.
constexpr float kHome = 0.15F;
// The whole pattern is at rest when more than this share of points has such a dot, …
constexpr double kMostAtRest = 0.85;
// … and less than this share of points is known to be there.
constexpr double kFewKnown = 0.7;
// The step that is expected is this share of the last one: between a stop and going on.
constexpr float kGoesOn = 0.5F;
// Least score of a step that is taken, share of all neighbours.
constexpr float kLeastScore = 0.15F;

float square(cv::Point2f v) {
  return v.dot(v);
}

float median_of(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void DotTracker::rest(std::span<const Dot> dots) {
  all_.clear();
  courses_.clear();
  for (const Dot& dot : dots) {
    all_.push_back({dot.place, dot.place, true});
    courses_.push_back({.seen = options_.trial});
  }
  std::vector<float> nearest;
  for (const Dot& one : dots) {
    float least = std::numeric_limits<float>::infinity();
    for (const Dot& other : dots) {
      if (&one != &other) least = std::min(least, square(one.place - other.place));
    }
    nearest.push_back(std::sqrt(least));
  }
  spacing_ = dots.size() < 2 ? 0 : median_of(nearest);
  link_neighbours();
  points_ = all_;
}

void DotTracker::link_neighbours() {
  const float far = kNeighbourhood * static_cast<float>(spacing_);
  std::vector<std::pair<float, int>> near;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    near.clear();
    for (std::size_t j = 0; j < all_.size(); ++j) {
      const float distance = square(all_[i].rest - all_[j].rest);
      if (j != i && distance < far * far && courses_[j].seen >= options_.trial)
        near.emplace_back(distance, static_cast<int>(j));
    }
    std::sort(near.begin(), near.end());
    near.resize(std::min(near.size(), kNeighbours));
    courses_[i].neighbours.clear();
    for (const auto& [distance, j] : near) courses_[i].neighbours.push_back(j);
  }
}

void DotTracker::list_candidates(std::span<const Dot> dots) {
  const auto far = static_cast<float>(options_.longest_step * spacing_);
  for (std::size_t i = 0; i < all_.size(); ++i) {
    courses_[i].candidates.clear();
    for (std::size_t k = 0; k < dots.size(); ++k) {
      const cv::Point2f step = dots[k].place - all_[i].now;
      if (square(step) < far * far) courses_[i].candidates.push_back({static_cast<int>(k), step});
    }
  }
}

// The share of neighbours that could have made this step.
float DotTracker::support(const Course& course, cv::Point2f step) const {
  if (course.neighbours.empty()) return 0;
  const auto width = static_cast<float>(options_.agreement * spacing_);
  float sum = 0;
  for (const int j : course.neighbours) {
    float nearest = std::numeric_limits<float>::infinity();
    for (const Candidate& other : courses_[static_cast<std::size_t>(j)].candidates)
      nearest = std::min(nearest, square(other.step - step));
    sum += std::exp(-nearest / (2 * width * width));
  }
  return sum / static_cast<float>(course.neighbours.size());
}

void DotTracker::weigh_candidates() {
  const auto cost = static_cast<float>(options_.surprise / (spacing_ * spacing_));
  for (Course& course : courses_) {
    for (Candidate& one : course.candidates)
      one.score = support(course, one.step) - cost * square(one.step - kGoesOn * course.step);
  }
  for (Course& course : courses_) {
    std::stable_sort(course.candidates.begin(), course.candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  }
}

// Once more, by the steps that the neighbours have chosen now.
void DotTracker::prefer_the_chosen() {
  const auto width = static_cast<float>(options_.agreement * spacing_);
  std::vector<std::vector<float>> scores;
  for (const Course& course : courses_) {
    auto& own = scores.emplace_back();
    for (const Candidate& one : course.candidates) {
      float sum = 0;
      for (const int j : course.neighbours) {
        const auto& others = courses_[static_cast<std::size_t>(j)].candidates;
        if (!others.empty()) sum += std::exp(-square(others.front().step - one.step) / (2 * width * width));
      }
      own.push_back(one.score + sum / static_cast<float>(std::max<std::size_t>(1, course.neighbours.size())));
    }
  }
  for (std::size_t i = 0; i < courses_.size(); ++i) {
    for (std::size_t k = 0; k < scores[i].size(); ++k) courses_[i].candidates[k].score = scores[i][k];
  }
}

// Each dot to one point, best scores first.
void DotTracker::assign(std::span<const Dot> dots) {
  std::vector<std::pair<int, const Candidate*>> offers;
  for (std::size_t i = 0; i < courses_.size(); ++i) {
    all_[i].seen = false;
    for (const Candidate& one : courses_[i].candidates) offers.emplace_back(static_cast<int>(i), &one);
  }
  std::stable_sort(offers.begin(), offers.end(),
                   [](const auto& a, const auto& b) { return a.second->score > b.second->score; });
  taken_.assign(dots.size(), 0);
  for (const auto& [point, offer] : offers) {
    SurfacePoint& one = all_[static_cast<std::size_t>(point)];
    char& taken = taken_[static_cast<std::size_t>(offer->dot)];
    if (one.seen || taken != 0 || offer->score < kLeastScore) continue;
    taken = 1;
    one.seen = true;
    one.now += offer->step;
    courses_[static_cast<std::size_t>(point)].step = offer->step;
    ++courses_[static_cast<std::size_t>(point)].seen;
  }
}

// Whether most neighbours that are seen moved otherwise, by so much that this must be another dot.
bool DotTracker::has_strayed(std::size_t point) const {
  const float far = kStray * static_cast<float>(spacing_);
  const cv::Point2f own = all_[point].now - all_[point].rest;
  int seen = 0, left = 0;
  for (const int j : courses_[point].neighbours) {
    const SurfacePoint& other = all_[static_cast<std::size_t>(j)];
    if (!other.seen) continue;
    ++seen;
    if (square(other.now - other.rest - own) > far * far) ++left;
  }
  return 2 * left > seen;
}

void DotTracker::drop_the_strayed() {
  std::vector<std::size_t> strayed;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    if (all_[i].seen && has_strayed(i)) strayed.push_back(i);
  }
  for (const std::size_t i : strayed) all_[i].seen = false;
}

// Whether there is a dot where nearly each point rests, and the points do not know it.
bool DotTracker::all_at_rest(std::span<const Dot> dots) const {
  const float near = kHome * static_cast<float>(spacing_);
  std::size_t at_rest = 0, known = 0;
  for (const SurfacePoint& point : all_) {
    at_rest += std::any_of(dots.begin(), dots.end(),
                           [&](const Dot& dot) { return square(dot.place - point.rest) < near * near; });
    known += square(point.now - point.rest) < near * near;
  }
  const auto all = static_cast<double>(all_.size());
  return static_cast<double>(at_rest) > kMostAtRest * all && static_cast<double>(known) < kFewKnown * all;
}

void DotTracker::go_home() {
  for (std::size_t i = 0; i < all_.size(); ++i) {
    all_[i].now = all_[i].rest;
    courses_[i].step = {};
  }
}

// Median displacement of the neighbours that are seen; that of the point itself if there are none.
cv::Point2f DotTracker::displacement_around(std::size_t point) const {
  std::vector<float> x, y;
  for (const int j : courses_[point].neighbours) {
    const SurfacePoint& other = all_[static_cast<std::size_t>(j)];
    if (!other.seen) continue;
    x.push_back(other.now.x - other.rest.x);
    y.push_back(other.now.y - other.rest.y);
  }
  return x.empty() ? all_[point].now - all_[point].rest : cv::Point2f(median_of(x), median_of(y));
}

void DotTracker::move_the_unseen() {
  for (std::size_t i = 0; i < all_.size(); ++i) {
    if (all_[i].seen) continue;
    const cv::Point2f now = all_[i].rest + displacement_around(i);
    courses_[i].step = now - all_[i].now;
    all_[i].now = now;
  }
}

// Dots that are no point's are new: they rest where they would be without their neighbours' displacement.
void DotTracker::adopt(std::span<const Dot> dots) {
  const float apart = kApart * static_cast<float>(spacing_);
  bool adopted = false;
  for (std::size_t k = 0; k < dots.size(); ++k) {
    if (taken_[k] != 0) continue;
    const SurfacePoint* nearest = nullptr;
    float least = std::numeric_limits<float>::infinity();
    for (const SurfacePoint& point : all_) {
      const float distance = square(point.now - dots[k].place);
      if (distance < least) least = distance, nearest = &point;
    }
    if (least < apart * apart) continue;
    const cv::Point2f displacement = nearest == nullptr ? cv::Point2f{} : nearest->now - nearest->rest;
    all_.push_back({dots[k].place - displacement, dots[k].place, true});
    courses_.push_back({.seen = 1, .adopted = true});
    adopted = true;
  }
  if (adopted) link_neighbours();
}

// A late point that was not seen in each picture of its trial, or that is lost where another one is seen, was
// no dot of its own.
bool DotTracker::is_superfluous(std::size_t point) const {
  if (!courses_[point].adopted || all_[point].seen) return false;
  const float apart = kApart * static_cast<float>(spacing_);
  return courses_[point].seen < options_.trial ||
         std::any_of(all_.begin(), all_.end(), [&](const SurfacePoint& other) {
           return other.seen && square(other.now - all_[point].now) < apart * apart;
         });
}

void DotTracker::forget_failures() {
  std::vector<char> kept(all_.size());
  bool changed = false;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    kept[i] = is_superfluous(i) ? 0 : 1;
    changed = changed || kept[i] == 0 ||
              (courses_[i].seen == options_.trial && courses_[i].adopted && all_[i].seen);
  }
  if (!changed) return;
  std::size_t next = 0;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    if (kept[i] == 0) continue;
    if (next != i) {
      all_[next] = all_[i];
      courses_[next] = std::move(courses_[i]);
    }
    ++next;
  }
  all_.resize(next);
  courses_.resize(next);
  link_neighbours();
}

const std::vector<SurfacePoint>& DotTracker::follow(std::span<const Dot> dots) {
  if (all_at_rest(dots)) go_home();
  list_candidates(dots);
  weigh_candidates();
  prefer_the_chosen();
  assign(dots);
  forget_failures();
  drop_the_strayed();
  move_the_unseen();
  adopt(dots);
  points_ = all_;
  for (std::size_t i = 0; i < all_.size(); ++i)
    points_[i].seen = all_[i].seen && courses_[i].seen >= options_.trial;
  return points_;
}

}  // namespace slipd::camera
