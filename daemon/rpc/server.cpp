#include "daemon/rpc/server.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <new>
#include <nlohmann/json.hpp>
#include <utility>

#include "daemon/log/log.hpp"
#include "daemon/record/flight_recorder.hpp"
#include "daemon/rpc/clients/descriptors.hpp"
#include "daemon/rpc/methods/estimate_text.hpp"

namespace slipd {
namespace {

using namespace std::chrono_literals;
using asio::posix::stream_descriptor;

// Runs `body`; false: it ran out of memory. The event loop continues.
template <typename Body>
bool had_memory(Body body) {
  try {
    body();
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  }
}

}  // namespace

void Clients::close_all() {
  for (const auto& client : all) client->close();
  all.clear();
}

void Clients::forget_closed() {
  std::erase_if(all, [this](const auto& client) {
    const bool gone = client->let_go();
    if (gone) dropped_by_closed += client->dropped();
    return gone;
  });
}

Server::Server(asio::io_context& io, ServiceContext& context, Clients& clients, Recorder& recorder,
               int listener)
    : context_(context),
      clients_(clients),
      methods_(context, recorder),
      listener_(io, listener),
      events_ready_(io, dup(context.board.io_wakeup.fd())),
      accept_pause_(io),
      frames_pause_(io),
      statistics_timer_(io),
      metrics_file_(context.settings.metrics),
      grasp_alerts_(context.board.grasps.size()),
      last_estimated_(context.board.sensors.size()),
      last_measured_(std::chrono::steady_clock::now()) {
  make_room_for(context.settings.socket.max_clients);
  clients_.owner.on_line = [this](const auto& client, std::string_view line) { handle(client, line); };
  clients_.owner.on_closed = [this] {
    clients_.forget_closed();
    context_.clients = clients_.all.size();
  };
  clients_.owner.on_notification_sent = [this](std::int64_t published_ns) {
    context_.delivery_latency.record(Now::read().monotonic_ns - published_ns);
  };
  context_.clients = clients_.all.size();
  context_.owed_bytes = [this] { return clients_.owner.owed.bytes(); };
  for (const auto& client : clients_.all) {
    for (Subscription& subscription : client->subscriptions) subscription.rebind(context.board);
  }
  for (const auto& sensor : context.board.sensors) told_.push_back(&clients_.told[sensor->name]);
  context_.rates_hz.resize(context.board.sensors.size());
  context_.repeats_hz.resize(context.board.sensors.size());
  last_repeated_.resize(context.board.sensors.size());
  context_.latency_last_minute.resize(context.board.sensors.size());
  had_memory([this] { tell_what_reload_changed(); });
  accept_when_ready();
  wait_for_events();
  judge_wakes();
  schedule_statistics();
}

Server::~Server() {
  methods_.fail_pending();
  context_.owed_bytes = [] { return std::size_t{0}; };
  clients_.owner.on_line = [](const auto&, const auto&) {};
  clients_.owner.on_closed = [] {};
  clients_.owner.on_notification_sent = [](std::int64_t) {};
}

// A handler that does nothing once the server is destroyed. Cancelling would be too late for one that is
// already queued.
template <typename Body>
auto Server::while_alive(Body body) {
  return [alive = std::weak_ptr<const bool>(alive_), body](const std::error_code& error) {
    if (!error && !alive.expired()) body();
  };
}

void Server::accept_when_ready() {
  listener_.async_wait(stream_descriptor::wait_read, while_alive([this] {
                         bool room = false;
                         if (had_memory([&] { room = accept_one(); }) && room) return accept_when_ready();
                         accept_pause_.expires_after(100ms);
                         accept_pause_.async_wait(while_alive([this] { accept_when_ready(); }));
                       }));
}

// False: the system has no descriptor or memory for another client now, or clients that were turned away
// cannot be let go yet.
bool Server::accept_one() {
  const std::size_t places = context_.settings.socket.max_clients;
  if (clients_.all.size() > places) clients_.forget_closed();
  if (clients_.all.size() > places) return false;
  UniqueFd socket(accept4(listener_.native_handle(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (!socket && (errno == EMFILE || errno == ENFILE || errno == ENOMEM || errno == ENOBUFS)) {
    return false;
  }
  if (!socket) return true;
  const bool room = clients_.all.size() < places;
  const auto client = std::make_shared<Client>(out_of_the_way(std::move(socket)), clients_.owner);
  clients_.all.insert(client);
  if (room) {
    client->start();
  } else {
    client->turn_away(
        rpc::kTooManyClients,
        "all " + std::to_string(places) + " places are taken; close a client or raise socket.max_clients");
    clients_.forget_closed();
  }
  context_.clients = clients_.all.size();
  return true;
}

void Server::wait_for_events() {
  events_ready_.async_wait(stream_descriptor::wait_read, while_alive([this] {
                             had_memory([this] { drain_events(); });
                             wait_for_events();
                           }));
}

void Server::drain_events() {
  context_.board.io_wakeup.clear();
  take_events();
  const auto& queues = context_.board.events;
  if (std::any_of(queues.begin(), queues.end(), [](const auto& each) { return each.read_available() > 0; }))
    context_.board.io_wakeup.notify();
  context_.board.shared.wake_others();
  trigger_on_grasp_slip();
  complete_frames();
  methods_.complete_rebias(false);
}

void Server::take_events() {
  Event event;
  // Only events that are queued now, so that a steady flow does not block the clients.
  for (EventQueue& queue : context_.board.events) {
    for (std::size_t left = queue.read_available(); left > 0 && queue.pop(event); --left) dispatch(event);
  }
}

// A subscription begins with the events after it, so those that wait are taken before.
void Server::handle(const std::shared_ptr<Client>& client, std::string_view line) {
  std::atomic<bool>& wake = context_.board.wake_for_each_event;
  const bool asleep = !wake.load(std::memory_order_relaxed);
  if (asleep) take_events();
  methods_.line(client, line);
  if (asleep && !client->subscriptions.empty()) wake.store(true, std::memory_order_relaxed);
}

// The flight recorder adds estimates to their frames while both are new.
void Server::judge_wakes() {
  const bool subscribed = std::any_of(clients_.all.begin(), clients_.all.end(),
                                      [](const auto& client) { return !client->subscriptions.empty(); });
  context_.board.wake_for_each_event.store(subscribed || context_.flight != nullptr,
                                           std::memory_order_relaxed);
}

void Server::complete_frames() {
  const auto again = methods_.complete_frames();
  if (!again || frames_pause_pending_) return;
  frames_pause_pending_ = true;
  frames_pause_.expires_at(*again);
  frames_pause_.async_wait(while_alive([this] {
    frames_pause_pending_ = false;
    had_memory([this] { complete_frames(); });
  }));
}

// Triggers the flight recorder when a grasp's alert becomes slip, even if no sensor's own alert does.
void Server::trigger_on_grasp_slip() {
  if (context_.flight == nullptr) return;
  for (std::size_t i = 0; i < grasp_alerts_.size(); ++i) {
    const GraspStatus& grasp = *context_.board.grasps[i];
    const Alert now = grasp.latest.load().alert;
    if (now == std::exchange(grasp_alerts_[i], now) || now != Alert::slip) continue;
    for (const std::size_t sensor : grasp.sensors)
      context_.flight->trigger(sensor, FlightRecorder::Reason::slip);
  }
}

void Server::dispatch(const Event& event) {
  Clients::Told& told = *told_[event.sensor];
  const bool slips = event.estimate.alert == Alert::slip && told.alert != Alert::slip;
  if (context_.flight != nullptr) context_.flight->add_estimate(event.sensor, event.estimate);
  notify_of_event(event, told);
  if (slips && context_.flight != nullptr)
    context_.flight->trigger(event.sensor, FlightRecorder::Reason::slip);
}

void Server::notify_of_event(const Event& event, Clients::Told& told) {
  const SensorStatus& status = *context_.board.sensors[event.sensor];
  notify_subscribers(event.estimate, status.name, status.simulated.load(std::memory_order_relaxed), told,
                     [&](Subscription& subscription, EventKind kind, std::uint64_t& lost) {
                       return subscription.accepts(event, kind, lost);
                     });
}

// Before the first event: none may ever come, if a device cannot be opened or its driver hangs, and none
// comes of sensors that the configuration does not have any more.
void Server::tell_what_reload_changed() {
  const std::int64_t now_ns = Now::read().monotonic_ns;
  for (std::size_t i = 0; i < told_.size(); ++i) {
    Event event{context_.board.sensors[i]->latest.load().estimate, static_cast<std::uint32_t>(i), 0};
    event.estimate.published_ns = now_ns;
    if (!told_[i]->holds(event.estimate)) notify_of_event(event, *told_[i]);
  }
  for (auto& [sensor, told] : clients_.told) {
    Estimate gone;
    gone.published_ns = now_ns;
    gone.state = State::fault;
    gone.alert = without_frames(told.alert);
    gone.alert_cause = told.alert_cause;
    if (std::ranges::find(told_, &told) != told_.end() || told.holds(gone)) continue;
    notify_subscribers(gone, sensor, false, told,
                       [&name = sensor](const Subscription& subscription, EventKind kind, std::uint64_t&) {
                         return subscription.wants(name, kind);
                       });
  }
}

// Sends the estimate, and events of what differs from what was told.
template <typename Accepts>
void Server::notify_subscribers(const Estimate& estimate, const std::string& sensor, bool simulated,
                                Clients::Told& told, Accepts accepts) {
  send_event(estimate, sensor, simulated, EventKind::estimate, accepts);
  if (estimate.alert != told.alert) send_event(estimate, sensor, simulated, EventKind::alert, accepts);
  if (estimate.state != told.state) send_event(estimate, sensor, simulated, EventKind::state, accepts);
  told = {estimate.state, estimate.alert, estimate.alert_cause};
}

template <typename Accepts>
void Server::send_event(const Estimate& estimate, const std::string& sensor, bool simulated, EventKind kind,
                        Accepts accepts) {
  static constexpr const char* kMethods[kEventKinds] = {"estimate", "alert", "state"};
  constexpr std::size_t kUsualBytes = 1024;
  std::shared_ptr<const Notification> head;  // made for the first subscriber
  for (const auto& client : clients_.all) {
    for (Subscription& subscription : client->subscriptions) {
      std::uint64_t lost = 0;
      if (!accepts(subscription, kind, lost)) continue;
      if (!head) {
        std::string text;
        text.reserve(kUsualBytes);
        text += R"({"jsonrpc":"2.0","method":")";
        text += kMethods[static_cast<std::size_t>(kind)];
        text += R"(","params":)";
        EstimateText(estimate, sensor, simulated).append_to(text, Now::read());
        text.pop_back();  // the closing brace: `dropped` is inserted before it
        head = std::make_shared<const Notification>(Notification{std::move(text), estimate.published_ns});
      }
      if (!had_memory([&] { client->notify(head, lost); })) client->close();
    }
  }
}

void Server::schedule_statistics() {
  statistics_timer_.expires_after(1s);
  statistics_timer_.async_wait(while_alive([this] {
    judge_wakes();
    had_memory([this] {
      take_events();
      update_statistics();
    });
    schedule_statistics();
  }));
}

void Server::update_statistics() {
  const auto now = std::chrono::steady_clock::now();
  const std::chrono::duration<double> passed = now - last_measured_;
  last_measured_ = now;
  for (std::size_t i = 0; i < last_estimated_.size(); ++i) {
    const std::uint64_t estimated = context_.board.sensors[i]->latest.load().counts.estimated;
    context_.rates_hz[i] = static_cast<double>(estimated - last_estimated_[i]) / passed.count();
    last_estimated_[i] = estimated;
    const SensorStatus& status = *context_.board.sensors[i];
    const std::uint64_t repeated = status.repeated.load(std::memory_order_relaxed);
    context_.repeats_hz[i] = static_cast<double>(repeated - last_repeated_[i]) / passed.count();
    last_repeated_[i] = repeated;
    context_.latency_last_minute[i].update(status.latency, now);
    for (const HealthNotice& notice :
         health_monitor_.check(i, status.name, status.facts().description, health_totals_of(status), now))
      write_log(LogLevel::warning, {status.name, notice.cause}, notice.text);
  }
  context_.delivery_latency_last_minute.update(context_.delivery_latency, now);
  std::uint64_t dropped = clients_.dropped_by_closed;
  for (const auto& client : clients_.all) dropped += client->dropped();
  context_.notifications_dropped = dropped;
  context_.clients_held_back = clients_.owner.held_back;
  context_.requests_refused = methods_.refused();
  metrics_file_.write_if_due(context_, now);
  methods_.complete_rebias(true);
  clients_.forget_closed();  // and those whose on_closed was not called for lack of memory
  context_.clients = clients_.all.size();
}

}  // namespace slipd
