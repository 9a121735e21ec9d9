// A gel with dots in front of a camera, in a grasp: frames of displacements of which is known when the object
// begins to slide and when it is lost. The contact is Hertz's, its shear that of any history of loads
// (core/contact/history.hpp), and the gel moves as an elastic layer does (gel_surface.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/contact/history.hpp"
#include "core/frame/layout.hpp"
#include "core/numeric/random.hpp"
#include "lab/frames/grasp_frames.hpp"
#include "lab/gels/gel_surface.hpp"

namespace lab {

// What becomes of a grasp after it has closed and lifted.
enum class GelCourse : std::uint8_t {
  held,      // a load that trembles
  shaken,    // a load that swings, by up to nine tenths of what friction holds
  loaded,    // loads that rise and fall, and are held
  eased,     // the grip is loosened, and still holds
  set_down,  // the load is taken off, as by a table
  drags,     // slides for a while, and is held again; the contact stays where it is on the gel
  rolls,     // the same of a ball: the contact goes with it
  falls,     // slides faster and faster until it is lost
};
inline constexpr std::size_t kGelCourses = 8;
const char* name_of(GelCourse course) noexcept;

// SI units. Times from the first picture.
struct GelGrasp {
  struct Load {
    double time_s = 0, normal_n = 0;
    double share = 0;  // of what friction holds
  };
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  GelCourse course = GelCourse::held;
  slipd::contact::BodyPair pair;
  double friction = 0.5;
  double kinetic = 1;  // friction of a contact that slides, over the other
  double toward_rad = 0, x_m = 0, y_m = 0;
  std::vector<Load> loads;           // in straight lines between; the last is the grasp's end
  double tremor_hz = 0, tremor = 0;  // its amplitude: a share of what friction holds
  double slides_s = kNever, stops_s = kNever, lost_s = kNever;
  double contact_m_per_s = 0;  // how fast the contact goes over the gel while the object slides

  bool is_lost() const noexcept { return lost_s < kNever; }
};

// The ranges are those of gel_frames.cpp. A pure function of its arguments.
GelGrasp draw_gel_grasp(GelCourse course, const slipd::RandomStream& random);

class GelFrames final : public GraspFrames {
 public:
  // The gel that all grasps are on.
  static constexpr double kThickness_m = 0.004, kModulus_pa = 0.3e6, kPoisson = 0.45;

  // `surface` and `layout` must outlive this object. noise_m: of each node and axis, standard deviation.
  GelFrames(const GelGrasp& grasp, const GelSurface& surface, const slipd::TaxelLayout& layout,
            double rate_hz, double noise_m, const slipd::RandomStream& random);

  bool next() override;
  slipd::FrameSlot& sense() override;

  // Of the gel's surface at a place now, without noise.
  struct Moved {
    double x_m = 0, y_m = 0;
  };
  Moved moved(double x_m, double y_m) const noexcept;

 private:
  GelGrasp::Load load_at(double time_s) const noexcept;
  double travelled_m(double time_s) const noexcept;

  const GelGrasp grasp_;
  const GelSurface& surface_;
  const slipd::TaxelLayout& layout_;
  const double rate_hz_, noise_m_;
  const slipd::RandomStream random_;
  slipd::contact::LoadHistory history_;
  std::vector<float> values_;
  slipd::FrameSlot slot_;
};

}  // namespace lab
