#include "bridges/web/server.hpp"

#include <pthread.h>
#include <slipd.h>

#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>

#include "bridges/support/log.hpp"
#include "bridges/web/answers/live_message.hpp"
#include "bridges/web/live_session.hpp"
#include "bridges/web/serving.hpp"

namespace slipd::web {

namespace asio = boost::asio;
using Tcp = asio::ip::tcp;

namespace {

constexpr std::chrono::milliseconds kAfterRefusal{100};  // before the next accept() after one that failed

Tcp::acceptor listening(asio::io_context& io, const Settings& settings) {
  const Tcp::endpoint at(asio::ip::make_address(settings.address), settings.port);
  try {
    Tcp::acceptor acceptor(io);
    acceptor.open(at.protocol());
    acceptor.set_option(Tcp::acceptor::reuse_address(true));
    acceptor.bind(at);
    acceptor.listen();
    return acceptor;
  } catch (const boost::system::system_error& error) {
    throw std::runtime_error(settings.address + " port " + std::to_string(settings.port) + ": " +
                             error.code().message() + "; the setting \"listen\" names another one");
  }
}

Message shared(std::string text) {
  return std::make_shared<const std::string>(std::move(text));
}

}  // namespace

void Serving::update_wanted() {
  Wanted now;
  for (const LiveSession* session : live) {
    ++now.browsers;
    if (const auto name = session->wants(); !name.empty()) now.looks.emplace(name);
  }
  now.method = !waiting_for_method.empty();
  {
    const std::lock_guard lock(mutex);
    if (now == wanted) return;
    wanted = std::move(now);
  }
  changed();
}

struct Server::State {
  State(const Settings& settings, std::function<void()> changed)
      : serving(settings, std::move(changed)), acceptor(listening(serving.io, settings)), pause(serving.io) {}

  void accept() {
    acceptor.async_accept([this](boost::system::error_code error, Tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (error) {  // no descriptor is left: try again when some connection has ended
        pause.expires_after(kAfterRefusal);
        return pause.async_wait([this](boost::system::error_code ended) {
          if (!ended) accept();
        });
      }
      take(std::move(socket));
      accept();
    });
  }

  void take(Tcp::socket socket) {
    serving.counts.add(Count::connections);
    const int most = serving.settings.max_browsers * (1 + serving.limits.connections_per_browser);
    if (serving.connections >= most) return serving.counts.add(Count::too_many);
    serve_http(serving, std::move(socket));
  }

  template <typename Body>
  void in_serving_thread(Body body) {
    asio::post(serving.io, std::move(body));
  }

  Serving serving;
  Tcp::acceptor acceptor;
  asio::steady_timer pause;
  std::uint16_t port = 0;
  std::atomic<bool> answered{true};  // what answers() posted last; relaxed: no other memory is read by it
  std::thread thread;
};

Server::Server(const Settings& settings, std::function<void()> changed)
    : state_(std::make_unique<State>(settings, std::move(changed))) {
  State& state = *state_;
  const auto at = state.acceptor.local_endpoint();
  state.port = at.port();
  state.serving.rules = std::make_unique<RequestRules>(
      host_names(settings.address, at.address().is_loopback(), at.port(), settings.hosts),
      settings.token_file.empty() ? std::string{} : read_token(settings.token_file));
  state.serving.hello = shared(hello_message(slipd_version(), settings.max_age_ms));
  const bool six = at.address().is_v6();
  bridges::log(bridges::LogLevel::notice, "serves http://" +
                                              (six ? "[" + settings.address + "]" : settings.address) + ":" +
                                              std::to_string(at.port()) + "/");
  state.accept();
  state.thread = std::thread([&state] { state.serving.io.run(); });
  pthread_setname_np(state.thread.native_handle(), "serve");
}

Server::~Server() {
  State& state = *state_;
  state.in_serving_thread([&state] {
    bridges::log(bridges::LogLevel::info, "served and refused: " + state.serving.counts.json());
    state.serving.changed = [] {};
    state.serving.waiting_for_method.clear();
    state.serving.io.stop();
  });
  state.thread.join();
}

Wanted Server::wanted() const {
  const std::lock_guard lock(state_->serving.mutex);
  return state_->serving.wanted;
}

bool Server::answers() {
  if (!state_->answered.exchange(false, std::memory_order_relaxed)) return false;
  state_->in_serving_thread([&state = *state_] { state.answered.store(true, std::memory_order_relaxed); });
  return true;
}

std::uint16_t Server::port() const noexcept {
  return state_->port;
}

void Server::publish_live(std::string message) {
  state_->in_serving_thread([&serving = state_->serving, text = shared(std::move(message))] {
    for (LiveSession* session : std::set(serving.live)) session->offer_live(text);
  });
}

void Server::publish_status(std::string message) {
  state_->in_serving_thread([&serving = state_->serving, text = shared(std::move(message))] {
    for (LiveSession* session : std::set(serving.live)) session->offer_status(text);
  });
}

void Server::publish_picture(const std::string& sensor, std::string picture) {
  state_->in_serving_thread([&serving = state_->serving, sensor, bytes = shared(std::move(picture))] {
    for (LiveSession* session : std::set(serving.live)) session->offer_picture(sensor, bytes);
    serving.update_wanted();
  });
}

void Server::publish_layout(const std::string& sensor, std::string layout) {
  state_->in_serving_thread([&serving = state_->serving, sensor, bytes = shared(std::move(layout))] {
    Message& known = serving.layouts[sensor];
    if (!known || *known != *bytes) known = bytes;
  });
}

void Server::publish_method(std::string json) {
  state_->in_serving_thread([&serving = state_->serving, text = shared(std::move(json))] {
    for (const auto& answer : std::exchange(serving.waiting_for_method, {})) answer(text);
    serving.update_wanted();
  });
}

}  // namespace slipd::web
