#include "core/grasp/grasp_load.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace slipd {
namespace {

using Motion = Eigen::Matrix<double, 6, 1>;  // of the body: velocity of the origin, and spin times the unit
using Curvature = Eigen::Matrix<double, 6, 6>;  // of the power
using Local = Eigen::Matrix<double, 3, 6>;      // to velocity along x and y and spin about the normal

// Places of equal parts of a Hertz contact's force, radius 1: rings within which lies (j + 1/2)/kRings of it.
constexpr std::size_t kRings = 5, kSpokes = 12;
struct Places {
  std::array<double, kRings * kSpokes> x{}, y{};
  Places() noexcept {
    for (std::size_t i = 0; i < x.size(); ++i) {
      const std::size_t ring = i / kSpokes, spoke = i % kSpokes;
      const double share = (static_cast<double>(ring) + 0.5) / kRings;
      const double radius = std::sqrt(1 - std::pow(1 - share, 2.0 / 3));
      // Rings are turned against each other.
      const double angle =
          2 * std::numbers::pi * (static_cast<double>(spoke) + 0.2 * static_cast<double>(ring)) / kSpokes;
      x[i] = radius * std::cos(angle);
      y[i] = radius * std::sin(angle);
    }
  }
};

struct Finger {
  Local local;
  double limit_n = 0, radius = 0;  // radius over the unit
};

// The least power of friction over all motions for which the load has the power 1.
class Search {
 public:
  Search(std::span<const FingerLoad> loads, double unit_m) noexcept : unit_m_(unit_m) {
    for (const FingerLoad& load : loads) add(load);
  }

  // Newton's method on powers with their kinks rounded less and less.
  void run() noexcept {
    constexpr std::array<double, 4> kRounded{0.3, 0.05, 5e-3, 5e-4};  // of the motion's size
    constexpr int kMostSteps = 30;
    constexpr double kSettled = 1e-7, kRidge = 1e-9;
    const double load = load_.norm();
    motion_ = load_ / (load * load);
    for (const double rounded : kRounded) {
      const double round = rounded * motion_.norm();
      for (int step = 0; step < kMostSteps; ++step) {
        Motion slope;
        Curvature curvature;
        const double power = power_of(motion_, round, &slope, &curvature);
        curvature.diagonal().array() += kRidge * curvature.trace() + std::numeric_limits<double>::min();
        // Along the plane load . motion = 1.
        const auto solver = curvature.ldlt();
        const Motion down = solver.solve(slope), normal = solver.solve(load_);
        const double on_normal = load_.dot(normal);
        if (!(on_normal > 0)) break;
        const Motion by = normal * (load_.dot(down) / on_normal) - down;
        const double gain = -slope.dot(by);
        if (!(gain > kSettled * power)) break;
        double part = 1;
        while (part > 1e-4 && !(power_of(motion_ + part * by, round, nullptr, nullptr) < power)) part /= 2;
        if (part <= 1e-4) break;
        motion_ += part * by;
      }
    }
    motion_ /= load_.dot(motion_);
  }

  bool loaded() const noexcept { return load_.norm() > 0; }
  double least() const noexcept { return power_of(motion_, 0, nullptr, nullptr); }
  // Of a finger with a limit of 1 N.
  double power_per_limit(std::size_t finger) const noexcept {
    return contact_power(fingers_[finger], motion_, 0, nullptr, nullptr);
  }

 private:
  void add(const FingerLoad& load) noexcept {
    if (count_ == fingers_.size()) return;
    const FingerPose& pose = load.pose;
    const Vector3 normal = cross(pose.x, pose.y);
    Vector3 place{};
    for (std::size_t i = 0; i < place.size(); ++i)
      place[i] = (pose.at_m[i] + load.center_x_m * pose.x[i] + load.center_y_m * pose.y[i]) / unit_m_;
    Finger& finger = fingers_[count_++];
    // x . (V + W x r) = x . V + (r x x) . W
    const Vector3 arm_x = cross(place, pose.x), arm_y = cross(place, pose.y);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      finger.local(0, k) = pose.x[i];
      finger.local(1, k) = pose.y[i];
      finger.local(2, k) = 0;
      finger.local(0, k + 3) = arm_x[i];
      finger.local(1, k + 3) = arm_y[i];
      finger.local(2, k + 3) = normal[i];
    }
    finger.limit_n = load.limit_n;
    finger.radius = load.radius_m / unit_m_;
    const Eigen::Vector3d force(load.shear_x_n, load.shear_y_n, load.torque_nm / unit_m_);
    load_ += finger.local.transpose() * force;
  }

  // The power of friction of one contact with a limit of 1 N. `slope`, `curvature` are added to, or null.
  double contact_power(const Finger& finger, const Motion& motion, double round, Motion* slope,
                       Curvature* curvature) const noexcept {
    static const Places kPlaces;
    const Eigen::Vector3d at = finger.local * motion;
    Eigen::Vector3d by = Eigen::Vector3d::Zero();
    Eigen::Matrix3d bend = Eigen::Matrix3d::Zero();
    double power = 0;
    constexpr double kShare = 1.0 / (kRings * kSpokes), kTiny = 1e-30;
    for (std::size_t i = 0; i < kPlaces.x.size(); ++i) {
      const double u = finger.radius * kPlaces.x[i], v = finger.radius * kPlaces.y[i];
      const double x = at[0] - at[2] * v, y = at[1] + at[2] * u;
      const double speed = std::sqrt(x * x + y * y + round * round + kTiny);
      power += kShare * speed;
      if (slope == nullptr) continue;
      const Eigen::Vector3d per(x / speed, y / speed, (y * u - x * v) / speed);
      by += kShare * per;
      Eigen::Matrix3d metric = Eigen::Matrix3d::Identity();
      metric(0, 2) = metric(2, 0) = -v;
      metric(1, 2) = metric(2, 1) = u;
      metric(2, 2) = u * u + v * v;
      bend += kShare / speed * (metric - per * per.transpose());
    }
    if (slope != nullptr) {
      *slope += finger.limit_n * (finger.local.transpose() * by);
      *curvature += finger.limit_n * (finger.local.transpose() * bend * finger.local);
    }
    return power;
  }

  double power_of(const Motion& motion, double round, Motion* slope, Curvature* curvature) const noexcept {
    if (slope != nullptr) {
      slope->setZero();
      curvature->setZero();
    }
    double power = 0;
    for (std::size_t i = 0; i < count_; ++i)
      power += fingers_[i].limit_n * contact_power(fingers_[i], motion, round, slope, curvature);
    return power;
  }

  double unit_m_;
  std::array<Finger, GraspLoad::kMost> fingers_;
  std::size_t count_ = 0;
  Motion load_ = Motion::Zero();  // its power by each part of the motion
  Motion motion_ = Motion::Zero();
};

}  // namespace

GraspLoad grasp_load(std::span<const FingerLoad> fingers) noexcept {
  GraspLoad result;
  // The unit of length: about what the fingers are apart, so that all parts of a motion are alike.
  double limits_n = 0, unit_m = 1e-3;
  for (const FingerLoad& finger : fingers) {
    limits_n += finger.limit_n;
    unit_m = std::max({unit_m, finger.radius_m, std::sqrt(dot(finger.pose.at_m, finger.pose.at_m))});
  }
  Search search(fingers, unit_m);
  if (!search.loaded()) return result;
  if (!(limits_n > 0)) {
    result.used_share = std::numeric_limits<double>::infinity();
    return result;
  }
  search.run();
  const double least = search.least();
  result.used_share = least > 0 ? 1 / least : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::min(fingers.size(), GraspLoad::kMost); ++i)
    result.per_limit_n[i] = -search.power_per_limit(i) * result.used_share * result.used_share;
  return result;
}

}  // namespace slipd
