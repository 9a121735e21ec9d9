// Takes a sensor's zero off its frames, and finds out what that zero is (docs/methods.md §33).
//
// A reading says nothing of itself about whether it is a load or an offset, so a zero is taken on two
// occasions only: when somebody asks for it, who answers for it that nothing touches the sensor, or when the
// sensor reads, within its noise, what it has to read without load. Before either there is none, and every
// frame is marked so. While the sensor is seen to be free, the zero slowly follows its drift; while it is
// touched, or may be, the zero stays. A zero that the readings contradict (core/zero/zero_check.hpp) is kept,
// but not used: frames are marked as without a zero until they agree with it again, or a new one is taken.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/frame/few_taxels.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/patch/patch.hpp"
#include "core/zero/bias.hpp"
#include "core/zero/frame_block.hpp"
#include "core/zero/zero_check.hpp"

namespace slipd {

// A block is a run of frames as mean and variance of each channel (FrameBlock). Standard errors are of a
// block's mean. Nothing in slipd-lab has a bias: checked by tests/core/zero/bias_estimator_test.cpp, on
// sensors with white and flicker noise, drift and touches.
struct BiasEstimatorOptions {
  // Blocks that move before a request is refused; 1 … 100. Too small: a hand that leaves refuses it. Too
  // large: the answer comes late.
  int max_tries = 8;
  // When a zero is doubted.
  ZeroCheckOptions check = {};
};

class BiasEstimator {
 public:
  // The smallest differences that the sensor tells; 0: not known, or none.
  struct Steps {
    float normal_pa = 0, shear_pa = 0;
  };

  // All memory there ever is. `exchangeable`: no serial number tells this sensor from another in its place,
  // so that a zero is checked against the first frame after the sensor was away.
  explicit BiasEstimator(const TaxelLayout& layout, Steps steps = {0, 0},
                         const BiasEstimatorOptions& options = {}, bool exchangeable = false);

  // Set-up. The zero of an earlier run; of as many taxels, else std::invalid_argument.
  void restore(const Bias& zero);

  // Set-up or acquire thread, after the device was away: whatever was seen of contacts no longer holds. The
  // zero does, if the next frame agrees with it. A zero that was asked for is answered with `gone`.
  void reopened() noexcept;

  // Set-up. Requests up to this one were for another device in this place: answered with `gone`.
  void skip_requests(std::uint32_t upto) noexcept;

  // Acquire thread: a new zero is wanted. Two blocks of frames later it is taken, if they stand still and do
  // not look like a contact; `force` asks for the first only. Requests are numbered from 1; an older one that
  // is not answered yet is answered with the newer one.
  void ask(std::uint32_t request, bool force) noexcept;

  // Acquire thread. `frame`: the driver's; afterwards less the bias, and marked by whether there is one.
  void apply(FrameSlot& frame) noexcept;

  // Acquire thread, after apply, when the frame is on its way: thinks about the frames so far, now and then
  // for some microseconds a thousand taxels. True if the report has changed.
  bool judge() noexcept;

  const BiasReport& report() const noexcept { return report_; }
  const Bias& zero() const noexcept { return zero_; }  // acquire thread's own; changes in judge

  // Acquire thread, out of real time. What the sensor last read, for Bias::last_pa; empty while there is no
  // zero, or a doubt about it, or no frame yet.
  std::vector<float> last_reading() const;

 private:
  // Of all normal pressures, and of both shears: a taxel that happens to flicker little is no better known
  // than the others.
  struct Kinds {
    float normal = 0, shear = 0;
  };
  Kinds mean_by_kind(std::span<const float> values) const noexcept;
  Kinds quieter_by_kind() const noexcept;
  float quieter(std::size_t channel) const noexcept;
  float step_pa(std::size_t channel) const noexcept {
    return channel < taxels_ ? steps_.normal_pa : steps_.shear_pa;
  }

  bool known() const noexcept { return report_.origin != BiasOrigin::none; }
  bool trusted() const noexcept { return known() && report_.doubt == BiasDoubt::none; }
  ZeroCheck::Floors floors() const noexcept;
  Frame block_as_frame() const noexcept;
  void note_absence() noexcept;
  void check_first(const Frame& frame) noexcept;
  void review() noexcept;
  bool fits_again(const Frame& block, bool below) const noexcept;
  bool shows_shape() const noexcept { return taxels_ >= kLeastTaxels; }
  std::span<const float> last_seen() const noexcept {
    return std::span(last_seen_).first(has_last_seen_ ? last_seen_.size() : 0);
  }
  void set_doubt(BiasDoubt doubt, const Frame& reading) noexcept;
  bool stands_still() const noexcept;
  bool reads_zero() const noexcept;
  bool near_bias() const noexcept;
  bool stands_out() noexcept;
  bool looks_touched() noexcept;
  void answer_request(bool still) noexcept;
  void answer(BiasResult what) noexcept;
  void take(BiasOrigin origin) noexcept;
  void follow() noexcept;
  void measure_noise() noexcept;
  void keep_block() noexcept;

  std::size_t taxels_;
  Steps steps_;
  BiasEstimatorOptions options_;
  PatchFinder finder_;
  FrameBlock block_;
  ZeroCheck check_;
  Bias zero_;
  BiasReport report_;
  std::vector<float> taken_bias_;                 // for the drift
  std::vector<float> last_mean_, last_variance_;  // of the block before
  std::uint32_t last_frames_ = 0;                 // 0: there is none
  std::int64_t last_ended_ns_ = 0;
  std::vector<float> apart_, sorted_;  // of the block from the bias
  bool whole_ = false;                 // a block waits for judge
  bool seen_free_ = false;             // since the device was opened
  bool asked_ = false, force_ = false;
  int tries_ = 0;
  const bool exchangeable_;
  std::int64_t last_frame_ns_ = 0;
  bool seen_frame_ = false;     // since the zero was restored or the sensor was made
  bool check_next_ = false;     // the next frame is the first after the sensor was away
  bool report_new_ = false;     // the report has changed in apply
  bool has_last_seen_ = false;  // last_seen_ is what the sensor read before it was away
  std::vector<float> last_seen_;
  std::uint32_t blocks_below_ = 0;
};

}  // namespace slipd
