// Where the contact is in a frame and what it carries: the first step of every estimator (docs/theory.md §6).
// Forces come from sums over the contact's own disc, in which noise of either sign cancels; a threshold only
// serves to find that disc. A taxel that feels nothing amid a contact is dead: its neighbours stand for it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/patch/disc_kernels.hpp"

namespace slipd {

// All of it of one frame. Without contact (touched false) only the noise means anything.
struct ContactPatch {
  bool in_contact = false;
  bool cut = false;                     // the disc reaches beyond the outermost taxels: its sums lack a part
  double normal_n = 0;                  // P
  double shear_x_n = 0, shear_y_n = 0;  // components of Q
  double shear_n = 0;                   // |Q|
  double direction_x = 1,
         direction_y = 0;  // unit vector along Q; shear is signed by it, so noise does not rectify
  double center_x_m = 0, center_y_m = 0;  // pressure centroid
  double radius_m = 0;                    // a, from the pressure's second moment: <r^2> = 2 a^2 / 5
  double noise_normal_pa = 0;             // standard deviation of one taxel, measured in this frame
  double noise_shear_pa = 0;
  double normal_sigma_n = 0, shear_sigma_n = 0;  // standard deviations of P and Q
  float peak_pa = 0;                             // the greatest pressure in the disc
  std::size_t count = 0;                         // of the disc's taxels
  std::size_t interpolated = 0;                  // of these, dead ones that neighbours stand for
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

class PatchFinder {
 public:
  explicit PatchFinder(const TaxelLayout& layout);

  // Estimate thread. Allocates nothing. `frame` has the layout's size.
  const ContactPatch& find(const Frame& frame) noexcept;

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
  void measure_shear_noise() noexcept;

  TaxelLayout layout_;
  const DiscKernels& kernels_;
  double left_m_, right_m_, bottom_m_, top_m_;  // the outermost taxels' edges
  std::vector<float> x_m_, y_m_;                // at least TaxelView::kLanes of each
  std::vector<float> channels_;                 // for frames that have fewer taxels, or dead ones
  std::vector<DeadTaxel> dead_;
  std::vector<TaxelRun> runs_, rest_;  // the disc, and all that is not of it
  double peak_pa_ = 0;
  ContactPatch patch_;
};

}  // namespace slipd
