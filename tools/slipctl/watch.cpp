#include "tools/slipctl/watch.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <optional>
#include <set>
#include <utility>

#include "tools/slipctl/client.hpp"
#include "tools/slipctl/terminal.hpp"
#include "tools/slipctl/view.hpp"
#include "tools/slipctl/watch_statistics.hpp"

namespace slipctl {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// Estimates of each sensor that are subscribed to, Hz: several for each dot of the history.
constexpr double kViewRateHz = 200;
// Time between two drawings of the screen.
constexpr milliseconds kDrawEvery{100};
// Time between two requests for the counts of frames.
constexpr milliseconds kCountEvery{1000};
// Notifications read after the end of the watch; more than a socket holds.
constexpr int kMostWaiting = 4096;
// Time between two attempts to connect to a slipd that has gone.
constexpr milliseconds kConnectEvery{500};

class Watcher {
 public:
  explicit Watcher(const WatchOptions& options) : options_(options) {
    state_.socket = options.socket;
    connect();
    before_ = after_;
    if (!options.json && !options.plain && ::isatty(STDOUT_FILENO) == 1) terminal_.emplace();
  }

  int run() {
    while (!over_) {
      wait();
      take_signals();
      take_keys();
      if (options_.seconds && elapsed_s() >= *options_.seconds) over_ = true;
      state_.elapsed_s = elapsed_s();
      try {
        if (!client_ && Clock::now() >= next_attempt_) reconnect();
        if (client_) take_notifications();
        if (client_ && over_) take_the_rest();
        tick();
      } catch (const ClientError& lost) {
        lose(lost.what());
      }
    }
    return finish();
  }

 private:
  double elapsed_s() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  void connect() {
    client_.emplace(options_.socket);
    std::vector<SensorWatch> chosen = chosen_sensors();
    for (SensorWatch& sensor : chosen)
      for (SensorWatch& before : state_.sensors)
        if (before.info.name == sensor.info.name) sensor.history = std::move(before.history);
    state_.sensors = std::move(chosen);
    subscribe();
    after_ = counts_from(client_->call("status"));
    take_counts();
    state_.connected = true;
  }

  // slipd was stopped or restarts. The watch tries to connect again without end. Earlier estimates are no
  // longer shown.
  void lose(const std::string& why) {
    client_.reset();
    next_attempt_ = Clock::now() + kConnectEvery;
    state_.grasps.clear();
    for (SensorWatch& sensor : state_.sensors) {
      sensor.latest.reset();
      sensor.frame = {};
    }
    if (std::exchange(state_.connected, false) && !terminal_)
      std::cerr << "slipctl: " << why << "; trying again" << std::endl;
  }

  void reconnect() {
    connect();
    before_ = after_;  // a new daemon counts from 0
    if (!terminal_) std::cerr << "slipctl: slipd is back" << std::endl;
  }

  std::vector<SensorWatch> chosen_sensors() {
    const std::vector<SensorInfo> known = sensors_from(client_->call("sensors"));
    watched_ = names_of_sensors(known);
    std::vector<SensorWatch> chosen;
    for (const SensorInfo& sensor : known)
      if (watched_.empty() || watched_.contains(sensor.name)) chosen.push_back({sensor, {}, {}, {}, 0, {}});
    return chosen;
  }

  // Of what is to be watched; a grasp stands for its sensors. Empty: all.
  std::set<std::string> names_of_sensors(const std::vector<SensorInfo>& known) {
    std::set<std::string> names;
    for (const std::string& name : options_.names) {
      if (std::ranges::find(known, name, &SensorInfo::name) != known.end()) {
        names.insert(name);
        continue;
      }
      const nlohmann::ordered_json named = part_of_gamma(client_->call("gamma"), name);
      for (const auto& grasp : named.at("grasps"))
        names.merge(grasp.at("sensors").get<std::set<std::string>>());
    }
    return names;
  }

  void subscribe() {
    nlohmann::ordered_json params{{"events", {"estimate", "alert"}}};
    if (!watched_.empty()) params["sensors"] = watched_;
    if (!options_.summary) params["max_rate_hz"] = options_.json ? options_.lines_per_s : kViewRateHz;
    client_->call("subscribe", params);
  }

  void wait() {
    Clock::time_point until = next_tick_;
    if (options_.seconds)
      until = std::min(until, start_ + std::chrono::ceil<Clock::duration>(
                                           std::chrono::duration<double>(*options_.seconds)));
    const auto left = std::chrono::ceil<milliseconds>(until - Clock::now());
    pollfd wanted[] = {{client_ ? client_->fd() : -1, POLLIN, 0},
                       {signals_.fd(), POLLIN, 0},
                       {terminal_ && terminal_->has_keys() ? STDIN_FILENO : -1, POLLIN, 0}};
    ::poll(wanted, std::size(wanted), static_cast<int>(std::max<std::int64_t>(0, left.count())));
    key_pressed_ = wanted[2].revents != 0;
  }

  void take_signals() {
    const ViewSignals asked = take_view_signals(signals_, terminal_);
    if (asked.end) over_ = true;
    if (asked.resized) next_tick_ = Clock::now();
  }

  void take_keys() {
    if (!key_pressed_ || !terminal_) return;
    const std::string keys = terminal_->read_keys();
    if (keys.find_first_of("qQ") != std::string::npos) over_ = true;
  }

  void take_notifications() {
    // For one tick at most, so that a flood of notifications cannot block keys.
    const auto until = std::max(Clock::now(), next_tick_) + kDrawEvery;
    while (Clock::now() < until && take_notification()) {
    }
  }

  // The notifications that arrived before the end but were not read yet.
  void take_the_rest() {
    for (int i = 0; i < kMostWaiting && take_notification(); ++i) {
    }
  }

  // False: none has arrived.
  bool take_notification() {
    const auto notification = client_->next(milliseconds(0));
    if (!notification) return false;
    const bool is_estimate = notification->method == "estimate";
    if (!is_estimate && notification->method != "alert") return true;
    const EstimateValues view = estimate_from(notification->params);
    statistics_.take(view, is_estimate);
    if (!is_estimate) return true;
    take_estimate(state_, view);
    if (options_.json) std::cout << notification->params.dump() << '\n';
    return true;
  }

  void tick() {
    const auto now = Clock::now();
    if (now < next_tick_ && !over_) return;
    const auto period =
        terminal_
            ? Clock::duration(kDrawEvery)
            : std::chrono::ceil<Clock::duration>(std::chrono::duration<double>(1 / options_.lines_per_s));
    next_tick_ = std::max(next_tick_ + period, now);
    if (client_ && now >= next_count_) {
      after_ = counts_from(client_->call("status"));
      take_counts();
      take_facts();
      next_count_ = now + kCountEvery;
    }
    if (terminal_) {
      state_.grip = ask_grip(options_.grip);
      if (client_) {
        take_frames();
        state_.grasps = grasps_from(client_->call("gamma"));
      }
      const auto [columns, rows] = terminal_->size();
      terminal_->show(draw_watch(state_, columns, rows, terminal_->depth()));
    } else if (!options_.json && client_) {
      for (const SensorWatch& sensor : state_.sensors)
        std::cout << plain_line(sensor, state_.elapsed_s) << '\n';
    }
    std::cout.flush();
  }

  void take_counts() {
    for (SensorWatch& sensor : state_.sensors)
      for (const SensorCounts& counts : after_)
        if (counts.name == sensor.info.name) sensor.counts = counts;
  }

  // A sensor's properties change when a device comes back or a model is ready.
  void take_facts() {
    for (const SensorInfo& info : sensors_from(client_->call("sensors")))
      for (SensorWatch& sensor : state_.sensors)
        if (sensor.info.name == info.name) sensor.info = info;
  }

  void take_frames() {
    for (SensorWatch& sensor : state_.sensors) try {
        take_frame(sensor, frame_from(client_->call("frame", {{"sensor", sensor.info.name}})));
      } catch (const RpcError&) {
        sensor.frame = {};  // no frame yet, or the device is disconnected
      }
  }

  int finish() {
    state_.elapsed_s = elapsed_s();
    if (client_) after_ = counts_from(client_->call("status"));
    if (!options_.picture.empty()) take_picture();
    terminal_.reset();
    if (!client_) std::cerr << "slipctl: slipd was gone at the end\n";
    if (options_.summary && options_.json)
      std::cout
          << nlohmann::ordered_json{{"summary", statistics_.json(before_, after_, state_.elapsed_s)}}.dump()
          << '\n';
    else if (options_.summary)
      std::cout << statistics_.text(before_, after_, state_.elapsed_s);
    std::cout.flush();
    if (options_.expect_slip && !statistics_.slip_seen()) {
      std::cerr << "slipctl: no slip was seen in " << state_.elapsed_s << " s\n";
      return 1;
    }
    return client_ ? 0 : 1;
  }

  void take_picture() {
    state_.grip = ask_grip(options_.grip);
    if (client_) {
      take_frames();
      state_.grasps = grasps_from(client_->call("gamma"));
    }
    std::ofstream file(options_.picture);
    file << to_svg(draw_watch(state_, 80, 24, ColourDepth::rgb), "slipctl watch");
    if (!file.flush()) throw ClientError("cannot write " + options_.picture);
  }

  const WatchOptions& options_;
  SignalWatch signals_;
  std::optional<RpcClient> client_;  // none: slipd is gone, and is tried again at next_attempt_
  Clock::time_point next_attempt_;
  std::set<std::string> watched_;  // names of sensors; empty: all
  WatchState state_;
  WatchStatistics statistics_;
  std::vector<SensorCounts> before_, after_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point next_tick_ = start_ + kDrawEvery;
  Clock::time_point next_count_ = start_ + kCountEvery;
  bool over_ = false;
  bool key_pressed_ = false;
  std::optional<Terminal> terminal_;  // last: restored before all else is destroyed
};

}  // namespace

int watch(const WatchOptions& options) {
  return Watcher(options).run();
}

}  // namespace slipctl
