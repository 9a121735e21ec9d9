// What is known of the load history of a contact, and how frames change that (docs/theory.md §4). Traction
// depends on the path of the load: only after a monotonic load does one frame determine its margin by itself.
// Estimate thread; plain state, nothing allocates.
#pragma once

#include <cstdint>

namespace slipd {

enum class HistoryState : std::uint8_t {
  // The load was followed since the grasp began. The likeliest friction's contact looks as under a shear that
  // only rose (Cattaneo 1938, Mindlin 1949): one frame determines its margin.
  monotonic,
  // The load was followed since the grasp began, and a regrip, an unloading or a reversal has left traction
  // of its own (Mindlin and Deresiewicz 1953): a frame is compared with the Winkler foundations.
  general,
  // The load before was not seen. It is taken for a monotonic one, and frames confirm that or not. No margin
  // is given meanwhile.
  assumed_monotonic,
  // The load before was not seen, and what was seen since is not monotonic. No frame is weighed, no margin is
  // given.
  unknown,
};

enum class HistoryEvent : std::uint8_t {
  contact_lost,          // the next frame in contact begins a grasp
  loaded_at_onset,       // the first frames of a grasp already carried shear, and their force did not grow
  shear_turned,          // shear left its axis; the foundations follow the load along one axis only
  outlier_run,           // no friction explained several frames in a row
  unseen,                // frames were missing or refused, and the contact may be another one
  frame_monotonic,       // the likeliest friction's contact looks as under a monotonic load
  frame_not_monotonic,   // it does not
  assumption_confirmed,  // enough frames looked as the assumed monotonic load would make them
};

// All transitions. An event without effect in a state leaves it as it is.
HistoryState next_state(HistoryState state, HistoryEvent event) noexcept;

constexpr bool is_known(HistoryState state) noexcept {
  return state == HistoryState::monotonic || state == HistoryState::general;
}

constexpr bool is_monotonic(HistoryState state) noexcept {
  return state == HistoryState::monotonic || state == HistoryState::assumed_monotonic;
}

// Checked with `slipd-lab histories --grasps 400`.
struct HistoryOptions {
  // Frames that an assumed monotonic load must explain before its margins are given, and frames with a clear
  // shear in a row that may lack evidence of friction before older estimates are no longer trusted; frames, 1
  // … 200. Too small: a grasp met after an unloading passes for a monotonic one, and margins have gaps. Too
  // large: such a grasp stays without a margin for longer, and others have one from the past.
  int confirming_frames = 25;
};

// The state, and the two counts of frames that change it.
class HistoryMonitor {
 public:
  explicit HistoryMonitor(const HistoryOptions& options = {}) noexcept : options_(options) {}

  HistoryState state() const noexcept { return state_; }

  void contact_lost() noexcept;

  // The history is not, or no longer, known: `why` is loaded_at_onset, shear_turned, outlier_run or unseen.
  void lose(HistoryEvent why) noexcept;

  // Whether the likeliest friction's contact looks monotonic at this frame.
  void classify(bool monotonic) noexcept;

  // A frame that no friction explains. True if it completes a run: the caller then calls lose(outlier_run).
  bool outlier() noexcept;

  // A frame that some friction explains; `as_monotonic`: it was read as one of a monotonic load.
  void explained(bool as_monotonic) noexcept;

 private:
  const HistoryOptions options_;
  HistoryState state_ = HistoryState::monotonic;
  std::uint32_t outliers_ = 0;  // frames in a row
  int confirming_ = 0;          // frames since the history was lost
};

}  // namespace slipd
