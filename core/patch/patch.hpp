// Where the contact is in a frame and what it carries: the first step of every estimator. Forces come from
// sums over the contact's own disc, in which noise of either sign cancels; a threshold only serves to find
// that disc (docs/methods.md §20). A taxel that senses nothing amid a contact is dead: its
// neighbours stand for it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/patch/disc_kernels.hpp"
#include "core/patch/unloaded_noise.hpp"

namespace slipd {

// Where a contact is and what it carries, in numbers: what may be kept beyond its frame. Without contact only
// the noise means anything.
struct ContactNumbers {
  bool in_contact = false;
  bool cut = false;                     // the disc reaches beyond the outermost taxels: its sums lack a part
  double normal_n = 0;                  // P
  double shear_x_n = 0, shear_y_n = 0;  // components of Q
  double shear_n = 0;                   // |Q|
  double direction_x = 1,
         direction_y = 0;  // unit vector along Q; shear is signed by it, so noise does not rectify
  double center_x_m = 0, center_y_m = 0;  // pressure centroid
  double radius_m = 0;                    // a, from the pressure's second moment: <r^2> = 2 a^2 / 5
  double noise_normal_pa = 0;             // standard deviation of one taxel
  double noise_shear_pa = 0;
  double normal_sigma_n = 0, shear_sigma_n = 0;  // standard deviations of P and Q
  // T: torque of the shear about the contact's centre and normal, N m, on the sensor; positive turns x to y.
  // Shear that pressing alone makes points outwards and has none. 0 of one force vector.
  double torque_nm = 0;
  // Its standard deviation, N m, by noise of shear and of the centre's place. Of a contact that is cut it
  // covers what the part beyond the edge may have.
  double torque_sigma_nm = 0;
  float peak_pa = 0;             // the greatest pressure in the disc
  float frame_peak_pa = 0;       // the greatest pressure of the whole frame, at least 0
  float frame_least_pa = 0;      // the least pressure of the whole frame
  float shear_x_extreme_pa = 0;  // the greatest |shear| along x in the disc
  float shear_y_extreme_pa = 0;  // the same along y
  bool finite = true;            // false: values that are not numbers, or beyond all sense
  std::size_t count = 0;         // of the disc's taxels
  std::size_t interpolated = 0;  // of these, dead ones that neighbours stand for
};

// All of one frame's contact.
struct ContactPatch : ContactNumbers {
  std::span<const TaxelRun> runs;  // the disc's taxels, by their numbers; valid until the next frame
  TaxelView taxels;                // the frame's channels, mended

  ContactPose pose() const noexcept {
    return {.x_m = static_cast<float>(center_x_m),
            .y_m = static_cast<float>(center_y_m),
            .direction_x = static_cast<float>(direction_x),
            .direction_y = static_cast<float>(direction_y),
            .radius_m = static_cast<float>(radius_m)};
  }

  // Calls with the number of each taxel of the disc.
  template <typename Body>
  void for_each_inside(const Body& body) const {
    for (const TaxelRun& run : runs) {
      for (std::uint32_t i = run.first; i < run.end; ++i) body(i);
    }
  }

  double shear_along_pa(std::uint32_t i) const noexcept {
    return direction_x * taxels.shear_x_pa[i] + direction_y * taxels.shear_y_pa[i];
  }
};

// Half of a taxel's diagonal, in sides; rounded up.
inline constexpr double kHalfDiagonal = 0.7072;

// side: a taxel's side; a: the contact's radius; peak: the frame's largest pressure. Dimensionless unless a
// unit is given. Checked with `slipd-lab tradeoff` (places and forces of contacts on all layouts), those of
// dead taxels with `slipd-lab stability --parts adversary`.
struct PatchOptions {
  // Taxels that the first guess of the disc is made from: above this many standard deviations, and above this
  // share of the peak; 2 … 5, 0 … 0.2. Too small: noise far off draws the guess. Too large:
  // the guess is too small, and takes more rounds.
  double first_guess_sigmas = 4;
  double first_guess_share = 0.02;
  // The disc that forces are summed over is wider than the contact by this factor, and by half a taxel's
  // diagonal; 1 … 1.3. Too small: the rim's force is lost. Too large: more noise is summed.
  double reach_factor = 1.06;
  // Floor of the pressure's second moment, over side^2; 0.005 … 0.5. Too small: a contact on one taxel has no
  // radius. Too large: small contacts come out larger.
  double min_second_moment = 0.05;
  // Standard deviation of the torque of a contact that is cut, of Q a; 0.05 … 1. Too small: the part that is
  // not sensed passes for a torque. Too large: a real torque goes unnoticed.
  double cut_torque_share = 0.3;
  // The disc is found anew until a round moves it by less than this, in sides, at most so many rounds; 0.001
  // … 0.1, 1 … 10. Too small, too many: costs time. Too large, too few: place and radius lag behind.
  double settled_sides = 0.01;
  int max_rounds = 3;
  // A contact is cut when it reaches beyond the outermost taxels' edges by more than this, in sides; 0 … 1.
  // Too small: whole contacts count as cut, and moments give no margin. Too large: a lost rim goes unnoticed.
  double cut_slack_sides = 0.25;

  // Whether neighbours stand for dead taxels. Not on pads that sense flat objects: those have hollows.
  bool fill_dead_taxels = true;
  // A taxel that senses less than this, of the peak, within this of the contact, of a^2, is dead; 0 … 0.3, 0
  // … 0.9. There a Hertz contact nowhere senses less than 0.45 of its peak. Too small: dead taxels stay. Too
  // large: hollow contacts are filled.
  double dead_below_share = 0.1;
  double dead_within_share = 0.8;
  // The largest share of dead taxels in the disc that neighbours stand for; 0.05 … 0.5. Too small: arrays
  // with many dead taxels are not repaired. Too large: hollow contacts are filled.
  double most_dead_share = 0.25;
  // Neighbours that sense something, to stand for a dead taxel; 1 … 4. Too small: rows of dead taxels are
  // guessed. Too large: dead taxels beside others stay.
  int dead_min_neighbours = 3;
};

class PatchFinder {
 public:
  explicit PatchFinder(const TaxelLayout& layout, const PatchOptions& options = {});

  // Estimate thread. Allocates nothing. `frame` has the layout's size.
  const ContactPatch& find(const Frame& frame) noexcept;

  // Estimate thread. The sensor's noise without load, for the frames to come; none: each frame's own is
  // measured, by its negative pressures and its free taxels.
  void set_noise(const std::optional<SensorNoise>& noise) noexcept { noise_ = noise; }

 private:
  void view(const Frame& frame) noexcept;
  void copy_channels() noexcept;
  void measure_normal_noise() noexcept;
  bool locate() noexcept;
  // A dead taxel, and the sums of what stands for it.
  struct DeadTaxel {
    std::uint32_t taxel = 0;
    int neighbours = 0;
    float normal_pa = 0, shear_x_pa = 0, shear_y_pa = 0;
  };
  std::size_t refine() noexcept;  // returns how many taxels may be dead
  DeadTaxelTest dead_taxel_test() const noexcept;
  bool interpolate_dead_taxels() noexcept;  // true if there were any
  DeadTaxel in_place_of(std::uint32_t taxel, float least_pa) const noexcept;
  void gather(double reach_m) noexcept;
  void sum_forces() noexcept;
  void measure_torque() noexcept;
  void measure_shear_noise() noexcept;
  void add_shared_noise() noexcept;

  // a by the pressure's second moment about its centroid.
  double radius_of(double second_moment_m2) const noexcept;

  TaxelLayout layout_;
  PatchOptions options_;
  const DiscKernels& kernels_;
  double left_m_, right_m_, bottom_m_, top_m_;  // the outermost taxels' edges
  std::vector<float> x_m_, y_m_;                // at least TaxelView::kLanes of each
  std::vector<float> channels_;                 // for frames that have fewer taxels, or dead ones
  std::vector<DeadTaxel> dead_;
  std::vector<TaxelRun> runs_, rest_;  // the disc, and all that is not of it
  double peak_pa_ = 0;
  double moment_pa_m_ = 0, squares_m2_ = 0;  // of the disc: ForceSums::moment and rr
  std::optional<SensorNoise> noise_;
  ContactPatch patch_;
};

}  // namespace slipd
