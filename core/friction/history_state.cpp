#include "core/friction/history_state.hpp"

#include "core/health/usual.hpp"

namespace slipd {

HistoryState next_state(HistoryState state, HistoryEvent event) noexcept {
  using enum HistoryState;
  switch (event) {
    case HistoryEvent::contact_lost:
      return monotonic;  // without a load there is no past: the next one rises from nothing
    case HistoryEvent::loaded_at_onset:
    case HistoryEvent::shear_turned:
    case HistoryEvent::outlier_run:
    case HistoryEvent::unseen:
      return assumed_monotonic;  // the commonest history, and the one that single frames can confirm
    case HistoryEvent::frame_monotonic:
      // Load beyond every earlier extreme wipes what these left (Masing): the state is monotonic again.
      if (state == general) return monotonic;
      if (state == unknown) return assumed_monotonic;
      return state;
    case HistoryEvent::frame_not_monotonic:
      if (state == monotonic) return general;          // followed all along: the foundations know the rest
      if (state == assumed_monotonic) return unknown;  // nothing to compare a frame with
      return state;
    case HistoryEvent::assumption_confirmed:
      if (state == assumed_monotonic)
        return monotonic;  // from here on the foundations are as good as followed
      return state;
  }
  return state;
}

void HistoryMonitor::contact_lost() noexcept {
  state_ = next_state(state_, HistoryEvent::contact_lost);
  outliers_ = confirming_ = 0;
}

void HistoryMonitor::lose(HistoryEvent why) noexcept {
  state_ = next_state(state_, why);
  confirming_ = 0;
}

void HistoryMonitor::classify(bool monotonic) noexcept {
  state_ = next_state(state_, monotonic ? HistoryEvent::frame_monotonic : HistoryEvent::frame_not_monotonic);
}

bool HistoryMonitor::outlier() noexcept {
  if (++outliers_ < kSureFrames) return false;
  outliers_ = 0;
  return true;
}

void HistoryMonitor::explained(bool as_monotonic) noexcept {
  outliers_ = 0;
  if (!as_monotonic || is_known(state_)) return;
  if (++confirming_ >= options_.confirming_frames)
    state_ = next_state(state_, HistoryEvent::assumption_confirmed);
}

}  // namespace slipd
