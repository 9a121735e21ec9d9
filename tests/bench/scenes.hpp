// What the benchmarks estimate: the paper's contacts on a pad of 14.4 mm, on any grid, and the models for
// them.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "core/chain/chain.hpp"
#include "core/frame/frame.hpp"
#include "paper/model/model.hpp"

namespace slipd::bench {

inline constexpr double kPad_m = 0.0144;
inline constexpr double kNoise = 0.01;  // relative: of p on p, of q on q

TaxelLayout pad(std::size_t side);
// Offset: 0 for svd-knn, which is bound to the place; 2 mm for all others.
Scene scene_of(MethodChoice method);
ChainSetup setup_of(std::size_t side, MethodChoice method);

// Trained with so many columns unless the setup's own are as many (0), or taken from the folder where it was
// kept.
std::shared_ptr<const Model> model_of(const ChainSetup& setup, std::size_t contacts = 0);

// Frames of their own memory, so many that they do not all stay in a core's own cache.
class Frames {
 public:
  // One contact each, drawn from the scene at a margin drawn from 0.05 to 0.95.
  Frames(const ChainSetup& setup, std::size_t count);
  const Frame& next() noexcept { return frames_[at_ = (at_ + 1) % frames_.size()]; }
  const std::vector<Frame>& all() const noexcept { return frames_; }

 private:
  std::vector<float> memory_;
  std::vector<Frame> frames_;
  std::size_t at_ = 0;
};

// One grasp of a simulated sensor as its driver would send it, 1 kHz, 2 % of sensor noise: pressed, loaded,
// unloaded, eased, for ever.
class Grasp {
 public:
  Grasp(std::size_t side, std::size_t count);
  const Frame& next() noexcept;  // time and sequence go on for ever

 private:
  std::vector<float> memory_;
  std::vector<Frame> frames_;
  Frame now_;
  std::size_t at_ = 0;
};

// Where models and what is handed to peers are kept: $SLIPD_BENCH_DIR, else the folder this runs in.
std::filesystem::path folder();

}  // namespace slipd::bench
