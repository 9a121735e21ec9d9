#include "lab/overload/skipping.hpp"

#include <array>

namespace lab {
namespace {

constexpr double kRunFrames = 20;  // mean length of a run of frames that come

// Frames come, or do not, until a draw says otherwise.
class Bursts {
 public:
  Bursts(unsigned k, slipd::RandomStream random) : k_(k), random_(random) {}

  bool operator()(std::uint64_t frame) {
    if (k_ <= 1 || frame <= 1) return true;
    const double mean_frames = coming_ ? kRunFrames : kRunFrames * (k_ - 1);
    if (random_.uniform(frame) < 1 / mean_frames) coming_ = !coming_;
    return coming_;
  }

 private:
  double k_;
  slipd::RandomStream random_;
  bool coming_ = true;
};

}  // namespace

std::string_view name_of(Skipping skipping) noexcept {
  static constexpr std::array<std::string_view, kSkippings> kNames{"regular", "random", "bursts"};
  return kNames[static_cast<std::size_t>(skipping)];
}

std::function<bool(std::uint64_t)> comes(Skipping skipping, unsigned k, slipd::RandomStream random) {
  switch (skipping) {
    case Skipping::random:
      return [=](std::uint64_t frame) { return frame <= 1 || random.uniform(frame) * k < 1; };
    case Skipping::bursts:
      return Bursts(k, random);
    case Skipping::regular:
      break;
  }
  return [k](std::uint64_t frame) { return (frame - 1) % k == 0; };
}

}  // namespace lab
