#include "bridges/support/feed.hpp"

#include <sys/epoll.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace slipd::bridges {
namespace {

// Between two attempts while slipd is away.
constexpr std::chrono::milliseconds kRetry{500};
// Estimates in a row before signals, the watchdog and other sockets are handled. Without a limit a bridge
// that is slower than its sensors would never handle them.
constexpr int kInARow = 64;

}  // namespace

Feed::Feed(Loop& loop, FeedOptions options, FeedListener listener)
    : options_(std::move(options)),
      listener_(std::move(listener)),
      slipd_(options_.socket),
      timer_(loop, [this] { refresh(); }),
      rest_(loop, [this] { take_events(); }),
      watch_(loop, slipd_.fd(), EPOLLIN, [this](std::uint32_t) { take_events(); }) {
  timer_.start({});
}

// The timer: asks for the inventory, and subscribes if there is no subscription yet. Once there is one,
// libslipd renews it.
void Feed::refresh() {
  timer_.start(options_.refresh);
  if (ask() && (!subscribed_ || subscribed_rate_hz_ != options_.max_rate_hz)) subscribe();
  if (!connected_) timer_.start(std::min(kRetry, options_.refresh));
}

void Feed::subscribe() {
  try {
    slipd_.subscribe({}, options_.max_rate_hz, options_.events, options_.answer_timeout_s);
    subscribed_ = true;
    subscribed_rate_hz_ = options_.max_rate_hz;
  } catch (const client::Error& error) {
    subscribed_ = false;
    lose(error.what());
    return;
  }
  take_events();  // one read may have brought estimates behind the answer
}

void Feed::limit_rate(double max_rate_hz) {
  if (options_.max_rate_hz == max_rate_hz) return;
  options_.max_rate_hz = max_rate_hz;
  if (connected_ && subscribed_) subscribe();  // otherwise the timer does it
}

// False: slipd is away.
bool Feed::ask() {
  try {
    Inventory now =
        ask_inventory(slipd_, options_.patience_s ? options_.patience_s() : options_.answer_timeout_s);
    const bool news = !connected_ || now != inventory_;
    inventory_ = std::move(now);
    connected_ = told_ = true;
    if (news && listener_.serves) listener_.serves(inventory_);
    return true;
  } catch (const std::runtime_error& error) {
    lose(error.what());
    return false;
  }
}

void Feed::lose(std::string_view why) {
  const bool news = connected_ || !told_;
  connected_ = false;
  told_ = true;
  timer_.start(std::min(kRetry, options_.refresh));
  if (news && listener_.away) listener_.away(why);
}

void Feed::take_events() {
  if (!subscribed_) return;
  for (int taken = 0; taken < kInARow; ++taken) {
    slipd_estimate estimate;
    const int code = slipd_next(slipd_.get(), options_.max_age_s, 0, &estimate);
    if (code == SLIPD_TIMEOUT) return;
    if (code == SLIPD_DONE) {
      take(estimate);
      continue;
    }
    // A subscription that slipd refuses, say because it has too many clients, is asked for anew by the timer.
    const std::string why = slipd_error_text(slipd_.get());
    if (code != SLIPD_DISCONNECTED) subscribed_ = false;
    lose(why);
    return;
  }
  rest_.start({});
}

void Feed::take(const slipd_estimate& estimate) {
  const std::string text = options_.texts ? slipd_event_text(slipd_.get()) : "";
  const bool known = connected_ && inventory_.has_sensor(estimate.name);
  if (!known && !(ask() && inventory_.has_sensor(estimate.name))) return;
  listener_.estimate(estimate, text);
}

}  // namespace slipd::bridges
