#include "daemon/rpc/server.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <new>
#include <nlohmann/json.hpp>
#include <utility>

#include "daemon/log/log.hpp"
#include "daemon/record/flight_recorder.hpp"
#include "daemon/rpc/descriptors.hpp"
#include "daemon/rpc/estimate_text.hpp"

namespace slipd {
namespace {

using namespace std::chrono_literals;
using asio::posix::stream_descriptor;

// False: there was no memory for `body`. What it was about is lost, the loop is not.
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

Server::Server(asio::io_context& io, ServiceContext& context, Clients& clients, Recorder& recorder,
               int listener)
    : io_(io),
      context_(context),
      clients_(clients),
      methods_(context, recorder),
      listener_(io, listener),
      news_(io, dup(context.board.io.fd())),
      pause_(io),
      rates_(io),
      metrics_file_(context.settings.metrics),
      last_(context.board.sensors.size()),
      grasp_alerts_(context.board.grasps.size()),
      last_estimated_(context.board.sensors.size()),
      last_measured_(std::chrono::steady_clock::now()) {
  make_room_for(context.settings.socket.max_clients);
  clients_.owner.line = [this](const auto& client, std::string_view line) { methods_.line(client, line); };
  clients_.owner.gone = [this](const auto& client) {
    clients_.dropped_for_gone += client->dropped();
    clients_.all.erase(client);
    context_.clients = clients_.all.size();
  };
  clients_.owner.told = [this](std::int64_t published_ns) {
    context_.told.record(Now::read().monotonic_ns - published_ns);
  };
  context_.clients = clients_.all.size();
  for (const auto& client : clients_.all) {
    for (Subscription& subscription : client->subscriptions) subscription.follow(context.board);
  }
  context_.rates_hz.resize(context.board.sensors.size());
  context_.last_minute.resize(context.board.sensors.size());
  accept_when_ready();
  listen_for_news();
  measure_rates();
}

Server::~Server() {
  methods_.give_up_waiting();
  clients_.owner = {
      .line = [](const auto&, const auto&) {}, .gone = [](const auto&) {}, .told = [](std::int64_t) {}};
}

// A handler that was on its way already when this server ended does nothing: cancelling would come too late
// for it.
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
                         pause_.expires_after(100ms);
                         pause_.async_wait(while_alive([this] { accept_when_ready(); }));
                       }));
}

// False: the system has no room for one more, for now.
bool Server::accept_one() {
  UniqueFd socket(accept4(listener_.native_handle(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (!socket && (errno == EMFILE || errno == ENFILE || errno == ENOMEM || errno == ENOBUFS)) {
    return false;
  }
  if (socket && clients_.all.size() >= context_.settings.socket.max_clients) {
    turn_away(socket);
  } else if (socket) {
    const auto client = std::make_shared<Client>(io_, out_of_the_way(std::move(socket)), clients_.owner);
    clients_.all.insert(client);
    context_.clients = clients_.all.size();
    client->start();
  }
  return true;
}

void Server::turn_away(const UniqueFd& socket) {
  const std::string text =
      rpc::error_text(rpc::kNoId, rpc::kTooManyClients,
                      "all " + std::to_string(context_.settings.socket.max_clients) +
                          " places are taken; close a client or raise socket.max_clients") +
      "\n";
  // A fresh socket has room for it.
  [[maybe_unused]] const auto sent =
      send(socket.get(), text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
}

void Server::listen_for_news() {
  news_.async_wait(stream_descriptor::wait_read, while_alive([this] {
                     had_memory([this] { take_news(); });
                     listen_for_news();
                   }));
}

void Server::take_news() {
  context_.board.io.clear();
  Event event;
  // As many as were there at first, so that a flood does not keep the loop from the clients.
  for (std::size_t left = context_.board.events.read_available();
       left > 0 && context_.board.events.pop(event); --left) {
    tell(event);
  }
  if (context_.board.events.read_available() > 0) context_.board.io.ring();
  follow_grasps();
  methods_.answer_frames();
  methods_.answer_rebias(false);
}

// A grasp may slip while each of its sensors alone would not say so.
void Server::follow_grasps() {
  if (context_.flight == nullptr) return;
  for (std::size_t i = 0; i < grasp_alerts_.size(); ++i) {
    const GraspStatus& grasp = *context_.board.grasps[i];
    const Alert now = grasp.latest.load().alert;
    if (now == std::exchange(grasp_alerts_[i], now) || now != Alert::slip) continue;
    for (const std::size_t sensor : grasp.sensors) context_.flight->keep(sensor, "slip");
  }
}

void Server::tell(const Event& event) {
  Last& last = last_[event.sensor];
  if (context_.flight != nullptr) context_.flight->note(event.sensor, event.estimate);
  tell(event, EventKind::estimate);
  if (event.estimate.alert != last.alert) {
    tell(event, EventKind::alert);
    if (event.estimate.alert == Alert::slip && context_.flight != nullptr)
      context_.flight->keep(event.sensor, "slip");
  }
  if (event.estimate.state != last.state) tell(event, EventKind::state);
  last = {event.estimate.state, event.estimate.alert};
}

void Server::tell(const Event& event, EventKind kind) {
  static constexpr const char* kMethods[kEventKinds] = {"estimate", "alert", "state"};
  constexpr std::size_t kUsualBytes = 1024;
  std::shared_ptr<const Notification> head;  // made for the first that wants it
  for (const auto& client : clients_.all) {
    for (Subscription& subscription : client->subscriptions) {
      std::uint64_t lost = 0;
      if (!subscription.wants(event, kind, lost)) continue;
      if (!head) {
        const SensorStatus& status = *context_.board.sensors[event.sensor];
        std::string text;
        text.reserve(kUsualBytes);
        text += R"({"jsonrpc":"2.0","method":")";
        text += kMethods[static_cast<std::size_t>(kind)];
        text += R"(","params":)";
        EstimateText(event.estimate, status.name, status.simulated.load(std::memory_order_relaxed))
            .append_to(text, Now::read());
        text.pop_back();  // its last brace: `dropped` comes before it
        head =
            std::make_shared<const Notification>(Notification{std::move(text), event.estimate.published_ns});
      }
      if (!had_memory([&] { client->notify(head, lost); })) client->close();
    }
  }
}

void Server::measure_rates() {
  rates_.expires_after(1s);
  rates_.async_wait(while_alive([this] {
    had_memory([this] { look_at_sensors(); });
    measure_rates();
  }));
}

void Server::look_at_sensors() {
  const auto now = std::chrono::steady_clock::now();
  const std::chrono::duration<double> passed = now - last_measured_;
  last_measured_ = now;
  for (std::size_t i = 0; i < last_estimated_.size(); ++i) {
    const std::uint64_t estimated = context_.board.sensors[i]->latest.load().counts.estimated;
    context_.rates_hz[i] = static_cast<double>(estimated - last_estimated_[i]) / passed.count();
    last_estimated_[i] = estimated;
    const SensorStatus& status = *context_.board.sensors[i];
    context_.last_minute[i].look(status.latency, now);
    for (const HealthNotice& notice :
         health_monitor_.look(i, status.name, status.facts().description, health_totals_of(status), now))
      say(LogLevel::warning, {status.name, notice.cause}, notice.text);
  }
  context_.told_last_minute.look(context_.told, now);
  std::uint64_t dropped = clients_.dropped_for_gone;
  for (const auto& client : clients_.all) dropped += client->dropped();
  context_.notifications_dropped = dropped;
  metrics_file_.look(context_, now);
  methods_.answer_rebias(true);
  // Those whose going could not be told of for want of memory.
  std::erase_if(clients_.all, [](const auto& client) { return client->closed(); });
  context_.clients = clients_.all.size();
}

}  // namespace slipd
