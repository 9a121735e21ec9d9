#include "tests/system/soak/disturbances.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include "core/storage/unique_fd.hpp"

namespace slipd::testing {
namespace {

using namespace std::chrono_literals;

}  // namespace

Disturbances::Disturbances(const Daemon& daemon, const TempFolder& folder, std::uint64_t seed)
    : daemon_(daemon),
      folder_(folder),
      random_(static_cast<std::minstd_rand::result_type>(seed)),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

std::array<std::uint64_t, Disturbances::kNames.size()> Disturbances::stop() {
  thread_ = {};
  return done_;
}

void Disturbances::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const std::size_t kind = random_() % kNames.size();
    try {
      act(kind);
      ++done_[kind];
    } catch (const std::exception& error) {
      ADD_FAILURE() << kNames[kind] << ": " << error.what();
      return;
    }
    std::this_thread::sleep_for(up_to(60) * 1ms);
  }
}

void Disturbances::act(std::size_t kind) {
  if (kind == 0) return pause();
  if (kind == 5 || kind == 6) return record(kind == 6);
  if (kind == 7) return never_read();
  RpcClient client(daemon_.socket());
  switch (kind) {
    case 1:
      client.result("subscribe");
      for (int i = up_to(50); i > 0; --i) client.line(1s);
      break;
    case 2:
      client.send(R"({"jsonrpc":"2.0","id":1,"meth)");
      break;
    case 3:
      for (int i = up_to(500); i > 0; --i) client.send_line(R"({"jsonrpc":"2.0","id":1,"method":)");
      break;
    case 4:
      client.send(std::string(70000, '['));
      EXPECT_TRUE(client.closed_by_peer());
      break;
    case 8:
      for (int i = up_to(20); i > 0; --i) client.call("frame", {{"sensor", sensor()}});
      break;
    case 9:
      client.call("flight", {{"sensor", sensor()}});
      break;
    default:
      client.result("status");
      client.result("metrics");
      client.result("gamma");
  }
}

void Disturbances::pause() {
  daemon_.program().signal(SIGSTOP);
  std::this_thread::sleep_for(up_to(200) * 1ms);
  daemon_.program().signal(SIGCONT);
}

void Disturbances::record(bool leave) {
  RpcClient client(daemon_.socket());
  if (leave) {
    client.call("record", {{"sensor", sensor()}, {"seconds", 1000}});
  } else {
    client.record(sensor(), 0.05 * up_to(4), folder_.file("soak.rec"));
  }
}

void Disturbances::never_read() {
  RpcClient client(daemon_.socket());
  client.send_line(R"({"jsonrpc":"2.0","id":1,"method":"subscribe"})");
  std::this_thread::sleep_for(up_to(500) * 1ms);
}

std::string Disturbances::sensor() {
  return "s" + std::to_string(random_() % 8);
}

}  // namespace slipd::testing
