// Whether a gel relaxes against its own recent past, by its field of displacements: an object that is held
// keeps the gel bent, and when it slips away the gel comes to rest (docs/displacement.md). Estimate thread;
// allocates in its constructor only.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/sliding/field_bends.hpp"
#include "core/sliding/rigid_motion.hpp"
#include "core/sliding/sliding.hpp"

namespace slipd {

// Lengths are root mean squares over the field's bends (FieldBends). Numbers that were chosen by recordings
// come from the shared trials of tools/gel-trials; its held-back objects judge them.
struct GelRelaxationOptions {
  // Pictures that are nearer in time than this add nothing; s, 0.01 … 0.1. Too small: windows are short on
  // fast cameras. Too large: slips are reported late. Chosen so
  // that each picture of a camera of 30 Hz counts.
  double least_step_s = 0.03;
  // Pictures for which a gel has to have relaxed that relaxes by slides_from, and fewer if by more; pictures
  // before those, which it is compared with; 4 … 25. Too small: shaking is a slip. Too large: told late, and
  // settling of a new grip is a slip. By the shared trials.
  std::size_t pictures = 12;
  // Of the past, at least so many, nearly half: slips soon after the start are not missed.
  std::size_t least_past() const noexcept { return (pictures - 1) / 2; }
  // Noise of a mean bend; mm, 0.0003 … 0.02. Too small: noise relaxes. Too large: weak contacts show nothing.
  // Chosen: what means of twelve pictures that follow each other differ by, over the root of two, in the
  // quietest tenth of the shared trials, with or without a slip.
  double noise_mm = 0.001;
  // Bend of one picture against the gel's rest from which on something touches it, and rigid motion or
  // stretch in one step that is a disturbance; mm, 0.01 … 0.1. Of means over pictures it is less, as their
  // noise is. Too small: noise and drift are contacts and pushes. Too large: weak ones are none. Chosen:
  // three times the bend that the noise of three dots makes, eight times the noise of a dot.
  double moved_mm = 0.02;
  // Weight of the gel's return to its rest beside the fall of its bend; 0 … 1. Too small: a fall in a
  // changing grip counts like one to rest. Too large: a light touch of a gel at rest counts like a hold. By
  // the shared trials.
  double rest_weight = 0.2;
  // Evidence from which on it is a slide; nats, 0.1 … 5. Too small: false alarms. Too large: slips are
  // missed. By the shared trials.
  double slides_from = 0.35;
  // After the start, as long as this, a jump, clear of moved_mm, from a picture at rest is one from stale
  // pictures of the camera: the past begins after it; s, 0 … 2. Too small: it counts as a slip. Too large: a
  // sudden slip is missed. Chosen: twelve stale pictures of a camera of 25 a second, as the shared trials'
  // cameras have them.
  double settling_s = 0.5;
};

struct GelState {
  // Of the surface from its place at rest, root mean square over the points that are seen, mm; none: too few.
  std::optional<double> displacement_mm;
  // Whether something touches the gel; none: its rest is not known yet.
  std::optional<bool> contact;
  // none: the past is too short, or too few points are seen.
  std::optional<Sliding> sliding;
  // Nats, >= 0.
  double evidence = 0;
};

// Not thread-safe.
class GelRelaxation {
 public:
  // Throws std::invalid_argument as FieldBends.
  explicit GelRelaxation(const TaxelLayout& layout, const GelRelaxationOptions& options = {});

  // The robot lets go of the object: what relaxes then is no slip, and is no past either.
  void set_releasing(bool releasing) noexcept;
  bool releasing() const noexcept { return releasing_; }
  // One frame of SensorClass::displacement, in order of time.
  const GelState& update(const Frame& frame) noexcept;

 private:
  struct Evidence {
    double nats = 0;      // the most that speaks for a slide
    bool held = false;    // the gel was bent in contact, in some past
    bool slides = false;  // it was, and enough speaks for a slide since
  };

  template <typename Value>
  std::span<Value> row(std::span<Value> ring, std::size_t ago) const noexcept;
  RigidMotion motion_since(std::size_t ago) const noexcept;
  void take(const Frame& frame) noexcept;
  void measure(const Frame& frame) noexcept;
  bool is_stale_jump(std::int64_t time_ns, double step_mm) const noexcept;
  void average(std::size_t newest, std::size_t pictures) noexcept;
  void find_rest() noexcept;
  Evidence weigh() noexcept;
  bool touches() const noexcept;
  bool bends_in_contact(std::size_t pictures) const noexcept;
  void judge() noexcept;

  const TaxelLayout layout_;
  const GelRelaxationOptions options_;
  const std::size_t kept_;  // pictures: past and now
  FieldBends bends_;
  // Of the kept pictures, in a ring: bends; displacement along x and then y.
  std::vector<float> history_, fields_;
  std::size_t newest_ = 0, count_ = 0;
  std::vector<float> mean_;                                        // bends, of some of them
  std::vector<float> rest_, unbent_;                               // bends of the gel at its least bent; none
  double rest_bend_mm_ = std::numeric_limits<double>::infinity();  // of rest_
  bool rest_seen_ = false;                                         // the gel was seen to bend against it
  mutable std::vector<float> change_;                              // of the field, along x and then y
  std::int64_t first_ns_ = -1, last_ns_ = 0;
  double last_step_mm_ = 0;
  RigidMotion step_;
  bool releasing_ = false;
  GelState state_;
};

}  // namespace slipd
