// The functions of slipd.h for the shared memory.
#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>

#include "clients/c/client.hpp"
#include "clients/c/estimate.hpp"

using namespace slipd::client;
using slipd::UniqueFd;

namespace {

// Longest sleep of slipd_wait before it looks at the heartbeat again, ns.
constexpr std::int64_t kLookNs = 50'000'000;
// A heartbeat that is older than so many of its periods is that of a slipd that has stopped. Fewer: a busy
// machine looks like a stop. The age of the estimate counts besides.
constexpr std::int64_t kBeatsMissed = 10;

bool alive(const slipd_client& s, std::int64_t now_ns, double max_age_s) noexcept {
  const std::int64_t beat_ns = s.board.heartbeat_ns();
  // A heartbeat after the caller looked at the clock; one that is still ahead is of another clock, as in a
  // time namespace, and says nothing of now.
  if (beat_ns > now_ns) now_ns = monotonic_ns();
  const auto patience = static_cast<double>(kBeatsMissed * s.board.heartbeat_period_ns());
  const double allowed_ns = max_age_s > 0 ? std::max(patience, 1e9 * max_age_s) : patience;
  return s.board_serves && !s.board.closed() && beat_ns <= now_ns &&
         static_cast<double>(now_ns - beat_ns) <= allowed_ns;
}

// The slot; negative: a code to return, with `estimate` cleared.
int usable_slot(slipd_client& s, const char* name, std::int64_t now_ns, double max_age_s,
                slipd_estimate& estimate) noexcept {
  const auto refuse = [&](int code, const char* why) {
    clear(estimate, name == nullptr ? "" : name, SLIPD_STATE_DISCONNECTED);
    return note(s, code, why);
  };
  s.error.front() = 0;
  if (!s.board.mapped()) return refuse(SLIPD_ATTACH_ANEW, "not attached: call slipd_attach first");
  const int slot = name == nullptr ? -1 : s.board.find(name);
  if (!alive(s, now_ns, max_age_s)) {
    const int code = refuse(SLIPD_ATTACH_ANEW, "slipd has stopped or was reloaded: call slipd_attach again");
    if (slot >= 0) {
      const auto last = s.board.record(slot);
      take_last_alert(alert_of(last), last.alert_cause, estimate);
    }
    return code;
  }
  if (slot < 0) return refuse(SLIPD_INVALID, "there is no sensor or grasp of this name");
  return slot;
}

// The present board stays mapped until there is another, so that an alert that was raised stands.
void attach(slipd_client& s, const char* wait_for, Clock::time_point until) {
  s.board_serves = false;
  s.attached.close();
  s.attached.connect(s.path);
  const std::string params = R"({"wait":[)" + (wait_for == nullptr ? std::string() : quoted(wait_for)) + "]}";
  s.attached.answer(s.attached.request("attach", params, until), until);
  const UniqueFd file = s.attached.take_descriptor();
  if (!file) throw Failure(SLIPD_DISCONNECTED, "slipd passed no memory");
  BoardView board;
  if (const std::string why = board.map(file); !why.empty()) throw Failure(SLIPD_INVALID, why);
  while (board.heartbeat_ns() == 0) {  // until the first round of slipd that writes it
    if (Clock::now() >= until) throw Failure(SLIPD_TIMEOUT, "slipd writes nothing into its memory");
    const timespec moment{0, 100'000};
    nanosleep(&moment, nullptr);
  }
  s.seen.assign(board.slots(), 0);
  s.board.swap(board);
  s.board_serves = true;
}

}  // namespace

int slipd_attach(slipd_client* s, const char* wait_for, double timeout_s) {
  return guarded(s, [&] {
    attach(*s, wait_for, after(timeout_s));
    return SLIPD_DONE;
  });
}

int slipd_latest(slipd_client* s, const char* name, double max_age_s, struct slipd_estimate* estimate) {
  if (s == nullptr || estimate == nullptr) return SLIPD_INVALID;
  const std::int64_t now_ns = monotonic_ns();
  const int slot = usable_slot(*s, name, now_ns, max_age_s, *estimate);
  if (slot < 0) return slot;
  fill(*estimate, s->board.name(slot), s->board.record(slot), now_ns, max_age_s);
  return SLIPD_DONE;
}

int slipd_wait(slipd_client* s, const char* name, double max_age_s, double timeout_s,
               struct slipd_estimate* estimate) {
  if (s == nullptr || estimate == nullptr) return SLIPD_INVALID;
  const std::int64_t until_ns = monotonic_ns() + static_cast<std::int64_t>(1e9 * seconds_of(timeout_s));
  for (;;) {
    const std::int64_t now_ns = monotonic_ns();
    const int slot = usable_slot(*s, name, now_ns, max_age_s, *estimate);
    if (slot < 0) return slot;
    const std::uint32_t published = s->board.published(slot);
    const auto record = s->board.record(slot);
    fill(*estimate, s->board.name(slot), record, now_ns, max_age_s);
    std::uint64_t& seen = s->seen[static_cast<std::size_t>(slot)];
    if (record.number > seen) {
      estimate->dropped = seen == 0 ? 0 : record.number - seen - 1;
      seen = record.number;
      return SLIPD_DONE;
    }
    if (now_ns >= until_ns) return SLIPD_TIMEOUT;
    s->board.wait(slot, published, std::min(until_ns, now_ns + kLookNs));
  }
}

double slipd_heartbeat_age(const slipd_client* s) {
  if (s == nullptr || !s->board_serves || s->board.closed()) return std::numeric_limits<double>::infinity();
  const std::int64_t beat_ns = s->board.heartbeat_ns();
  const std::int64_t now_ns = monotonic_ns();
  if (beat_ns > now_ns) return std::numeric_limits<double>::infinity();  // of another clock
  return 1e-9 * static_cast<double>(now_ns - beat_ns);
}
