// Follows dots from picture to picture. No grid has to be whole: a dot's neighbours say where it has gone,
// because a gel moves as a whole. For each dot, the steps to all dots found near it are weighed by how many
// neighbours could have made the same step; so a step of nearly half the spacing is followed. A dot that is
// not found moves with its neighbours until it is found again; one that has left its neighbours by half the
// spacing was another dot, and is sought anew. One thread's own.
#pragma once

#include <opencv2/core/types.hpp>
#include <span>
#include <vector>

#include "camera/surface/dot_finder.hpp"
#include "camera/surface/surface_point.hpp"

namespace slipd::camera {

struct DotTrackerOptions {
  // Longest step from one picture to the next; spacings of dots, 0.3 … 1. Too small: a fast slip is lost. Too
  // large: more candidates for each dot, and time.
  double longest_step = 0.8;
  // How far steps of neighbours may differ and still agree; spacings, 0.05 … 0.3. Too small: stretch of the
  // gel looks like disagreement. Too large: a neighbour's dot is taken for one's own.
  double agreement = 0.12;
  // What a step costs that is a spacing away from the expected one; share of all neighbours, 0.1 … 2. Too
  // small: on a regular grid a step of more than half the spacing wins. Too large: a sudden step is not
  // followed.
  double surprise = 0.5;
  // Pictures in which a new dot must be seen before its motion counts; 1 … 20. Too small: specks count. Too
  // large: dots that an object has hidden come late.
  int trial = 3;
};

class DotTracker {
 public:
  explicit DotTracker(const DotTrackerOptions& options) : options_(options) {}

  // These dots are at rest, and all that is known. Needs at least one.
  void rest(std::span<const Dot> dots);
  // Where the points are in the next picture, in which these dots were found: those at rest first, in their
  // order, then dots that came later.
  const std::vector<SurfacePoint>& follow(std::span<const Dot> dots);

  const std::vector<SurfacePoint>& points() const noexcept { return points_; }
  // Median distance to the nearest neighbour at rest, px; 0: fewer than two dots.
  double spacing_px() const noexcept { return spacing_; }

 private:
  struct Candidate {
    int dot = 0;
    cv::Point2f step;
    float score = 0;
  };
  // What is known of a point beside its place.
  struct Course {
    int seen = 0;          // pictures
    bool adopted = false;  // came after rest
    cv::Point2f step = {};
    std::vector<int> neighbours = {};
    std::vector<Candidate> candidates = {};
  };

  void link_neighbours();
  void list_candidates(std::span<const Dot> dots);
  void weigh_candidates();
  void prefer_the_chosen();
  void assign(std::span<const Dot> dots);
  bool has_strayed(std::size_t point) const;
  void drop_the_strayed();
  bool all_at_rest(std::span<const Dot> dots) const;
  void go_home();
  void move_the_unseen();
  void adopt(std::span<const Dot> dots);
  void forget_failures();
  bool is_superfluous(std::size_t point) const;
  float support(const Course& course, cv::Point2f step) const;
  cv::Point2f displacement_around(std::size_t point) const;

  DotTrackerOptions options_;
  std::vector<SurfacePoint> all_;     // also those on trial
  std::vector<SurfacePoint> points_;  // for the caller: those on trial are not seen
  std::vector<Course> courses_;
  std::vector<char> taken_;  // dots that are a point's
  double spacing_ = 0;
};

}  // namespace slipd::camera
