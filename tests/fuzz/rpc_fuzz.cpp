// Any bytes from clients of the socket, cut into any pieces: each line gets one complete answer,
// concurrently with estimates and other clients. In the input, a byte from 1 to 8 is an order (below); all
// other bytes are sent.
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <asio/io_context.hpp>
#include <nlohmann/json.hpp>

#include "core/storage/descriptor_passing.hpp"
#include "daemon/rpc/server.hpp"
#include "daemon/rt/clock.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace slipd;
using fuzz::demand;

constexpr std::size_t kSensors = 2, kMostPeers = 3;

// The kernel chooses the socket's name.
UniqueFd make_listener(sockaddr_un& address, socklen_t& length) {
  UniqueFd fd(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  address.sun_family = AF_UNIX;
  length = sizeof address;
  auto* const any = reinterpret_cast<sockaddr*>(&address);
  demand(bind(fd.get(), any, sizeof address.sun_family) == 0 && listen(fd.get(), 8) == 0);
  demand(getsockname(fd.get(), any, &length) == 0);
  return fd;
}

// The client's end of one connection.
class Peer {
 public:
  Peer(const sockaddr_un& address, socklen_t length)
      : fd_(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
    demand(connect(fd_.get(), reinterpret_cast<const sockaddr*>(&address), length) == 0);
  }

  void say(const std::string& text, bool with_descriptor) {
    if (text.empty()) return;
    const UniqueFd file(with_descriptor ? memfd_create("record", MFD_CLOEXEC) : -1);
    if (send_passing(fd_.get(), text, file.get(), MSG_NOSIGNAL) > 0)
      lines_ += static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  }

  void finish() { shutdown(fd_.get(), SHUT_WR); }

  void hear() {
    char bytes[65536];
    for (ssize_t got = 1; got > 0;) {
      got = recv(fd_.get(), bytes, sizeof bytes, MSG_DONTWAIT);
      if (got > 0) heard_.append(bytes, static_cast<std::size_t>(got));
    }
  }

  // Called after the last piece.
  void check() {
    hear();
    demand(heard_.empty() || heard_.back() == '\n');
    std::size_t answers = 0;
    for (std::size_t at = 0; at < heard_.size();) {
      const std::size_t end = heard_.find('\n', at);
      const auto line = nlohmann::json::parse(heard_.substr(at, end - at));
      const auto& first = line.is_array() ? line.at(0) : line;
      demand(first.at("jsonrpc") == "2.0");
      if (!first.contains("method")) ++answers;
      at = end + 1;
    }
    demand(answers <= lines_ + 1);  // one more: a last line without its end, or the refusal of this client
  }

 private:
  UniqueFd fd_;
  std::string heard_;
  std::size_t lines_ = 0;
};

Settings make_settings() {
  Settings settings;
  for (std::size_t i = 0; i < kSensors; ++i)
    settings.sensors.push_back({.setup = {.name = i == 0 ? "left" : "right",
                                          .layout = TaxelLayout::grid(2, 2, 1e-3),
                                          .profile = {},
                                          .device = {},
                                          .options = {}},
                                .driver = "none",
                                .friction = {},
                                .gain = {}});
  settings.grasps.push_back({"gripper", {"left", "right"}, {}});
  settings.can.emplace().interface = "can0";
  settings.socket.max_clients = kMostPeers - 1;
  return settings;
}

class Stage {
 public:
  Stage() {
    for (const SensorSettings& sensor : settings_.sensors) {
      SensorStatus& status =
          *board_.sensors.emplace_back(std::make_unique<SensorStatus>(sensor.setup.name, sensor.driver));
      status.change_facts([&](DeviceFacts& facts) { facts.layout = sensor.setup.layout; });
      status.bias.needed = true;
      status.link = DeviceLink::open;
    }
    board_.events.emplace_back();
    board_.grasps.push_back(std::make_unique<GraspStatus>("gripper", std::vector<std::size_t>{0, 1}));
    const UniqueFd listener = make_listener(address_, length_);
    server_.emplace(io_, context_, clients_, recorder_, dup(listener.get()));
    connect();
  }

  void play(const std::uint8_t* data, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      const bool is_order = data[i] >= 1 && data[i] <= 8;
      if (!is_order) text_ += static_cast<char>(data[i]);
      if (is_order || text_.size() > 16384) say();
      if (is_order) order(data[i]);
    }
    say();
    for (auto& peer : peers_) {
      peer->hear();
      peer->finish();
    }
    turn();
    server_.reset();  // a request that waits for a frame gets its error
    recorder_.end_all();
    for (int i = 0; i < 3; ++i) {
      turn();
      for (auto& peer : peers_) peer->hear();
    }
    clients_.close_all();
    turn();
    for (auto& peer : peers_) peer->check();
  }

 private:
  void turn() {
    for (int i = 0; i < 100 && io_.poll() > 0; ++i) io_.restart();
    io_.restart();
  }
  void connect() {
    peers_.push_back(std::make_unique<Peer>(address_, length_));
    turn();
  }
  void say() {
    peers_.back()->say(std::exchange(text_, {}), std::exchange(descriptor_, false));
    turn();
  }
  void order(std::uint8_t what) {
    switch (what) {
      case 2:
        peers_.back()->hear();
        break;
      case 3:
        peers_.back()->finish();
        break;
      case 4:
        publish();
        break;
      case 5:
        for (auto& status : board_.sensors) status->frame_copy.fill_if_requested(nullptr);
        board_.io_wakeup.notify();
        break;
      case 6:
        descriptor_ = true;
        break;
      case 7:
        for (auto& status : board_.sensors) status->bias.complete(status->bias.newest_request().number);
        board_.io_wakeup.notify();
        break;
      case 8:
        if (peers_.size() < kMostPeers) connect();
        break;
      default:  // what was collected so far is a piece of its own
        break;
    }
    turn();
  }

  void publish() {
    Published said = board_.sensors[0]->latest.load();
    said.estimate.state = static_cast<State>(++said.estimate.sequence % 8);
    said.estimate.alert = static_cast<Alert>(said.estimate.sequence % 3);
    said.estimate.published_ns = Now::read().monotonic_ns;
    if (said.estimate.state == State::ok) said.estimate.gamma = 0.5;
    board_.sensors[0]->latest.store(said);
    board_.events.front().push({said.estimate, 0, 0});
    board_.io_wakeup.notify();
  }

  const Settings settings_ = make_settings();
  Board board_;
  ServiceContext context_{.settings = settings_,
                          .board = board_,
                          .realtime = {},
                          .ring_estimate = [] {},
                          .latency_last_minute = {},
                          .rates_hz = {},
                          .repeats_hz = {}};
  asio::io_context io_;
  Clients clients_{io_};
  Recorder recorder_{io_};
  sockaddr_un address_{};
  socklen_t length_ = 0;
  std::optional<Server> server_;
  std::vector<std::unique_ptr<Peer>> peers_;
  std::string text_;
  bool descriptor_ = false;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto stage = std::make_unique<Stage>();
  stage->play(data, size);
  return 0;
}
