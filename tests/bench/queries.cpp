// The parts of daemon-bench that ask: slipd, Redis and a server that only echoes, by the same clients.
#include <algorithm>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/daemon_parts.hpp"
#include "tests/bench/floors.hpp"
#include "tests/bench/load.hpp"
#include "tests/bench/redis.hpp"
#include "tests/bench/running.hpp"

namespace slipd::bench {
namespace {

using testing::Daemon;
using testing::TempFolder;
using namespace std::chrono_literals;
using std::chrono::milliseconds;

constexpr int kRounds = 5;
constexpr const char* kPerf = "/usr/bin/perf";

Asking gamma_query(const Daemon& daemon, int clients, int subscribers) {
  return {.socket = daemon.socket(),
          .request = R"({"jsonrpc":"2.0","id":1,"method":"gamma"})"
                     "\n",
          .newlines = 1,
          .clients = clients,
          .subscribers = subscribers,
          .subscription = R"({"jsonrpc":"2.0","id":1,"method":"subscribe"})"
                          "\n"};
}

json to_json(const Asked& asked) {
  json values = bench::to_json(asked.waits);
  values.update({{"per_s", asked.per_second}, {"bytes", asked.answer_bytes}});
  return values;
}

// The run with the median throughput: a machine that others use as well is slower now and then.
const Asked& usual_of(std::vector<Asked>& asked) {
  const auto middle = asked.begin() + static_cast<std::ptrdiff_t>(asked.size() / 2);
  std::nth_element(asked.begin(), middle, asked.end(),
                   [](const Asked& a, const Asked& b) { return a.per_second < b.per_second; });
  return *middle;
}

void in_turn(const std::map<std::string, Asking>& servers, int clients, milliseconds each) {
  std::map<std::string, std::vector<Asked>> asked;
  for (int round = 0; round < kRounds; ++round) {
    for (const auto& [server, asking] : servers) asked[server].push_back(ask_for(asking, each));
  }
  for (auto& [server, of] : asked) {
    json values = to_json(usual_of(of));
    values.update({{"server", server}, {"clients", clients}, {"subscribers", 0}});
    say("queries", values);
  }
}

using Counts = std::map<std::string, double>;

// What perf counted: lines of a count, a unit, an event and more.
Counts counts_in(const std::string& text) {
  const std::string prefix = "sys_enter_";
  Counts counts;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const auto at = line.find(prefix);
    if (at == std::string::npos) continue;
    const auto name = at + prefix.size();
    counts[line.substr(name, line.find(';', name) - name)] = std::strtod(line.c_str(), nullptr);
  }
  return counts;
}

// How often a server enters the kernel for an answer, by what for: over a part of the time in which it is
// asked, divided by its reads, each of which is a request.
void calls(const std::string& server, pid_t pid, const Asking& asking) {
  const std::pair<const char*, std::vector<std::string>> kinds[] = {{"read", {"recvfrom", "recvmsg", "read"}},
                                                                    {"write", {"sendto", "sendmsg", "write"}},
                                                                    {"wait", {"epoll_wait", "epoll_pwait"}},
                                                                    {"control", {"epoll_ctl"}}};
  std::vector<std::string> command{kPerf, "stat", "--field-separator", ";", "--pid", std::to_string(pid)};
  for (const auto& [kind, names] : kinds) {
    for (const std::string& name : names)
      command.insert(command.end(), {"--event", "syscalls:sys_enter_" + name});
  }
  command.insert(command.end(), {"/usr/bin/sleep", brief ? "0.02" : "0.5"});
  const TempFolder folder;
  testing::Program perf(folder, "perf", command);
  std::optional<int> code;
  while (!(code = perf.wait(0ms))) ask_for(asking, brief ? 50ms : 1500ms);
  if (*code != 0)
    return say(
        "refused",
        {{"peer", "perf"}, {"why", perf.errors()}, {"remedy", "run it as root, with linux-perf installed"}});
  Counts counts = counts_in(perf.errors());
  double requests = 0;
  for (const std::string& name : kinds[0].second) requests = std::max(requests, counts[name]);
  json values{{"server", server}, {"clients", asking.clients}};
  for (const auto& [kind, names] : kinds) {
    double sum = 0;
    for (const std::string& name : names) sum += counts[name];
    values[kind] = requests > 0 ? sum / requests : 0;
  }
  say("calls", values);
}

}  // namespace

void queries() {
  const TempFolder folder;
  const Daemon daemon(config(folder, json::array({trial("left", 16, 1000)}), "moments"),
                      testing::trial_drivers(), state());
  wait_for_estimates(daemon, 100);
  const auto whole = length(4s);
  const std::size_t bytes = ask_for(gamma_query(daemon, 1, 0), length(200ms)).answer_bytes;
  const EchoServer echo(folder.file("echo.sock"), bytes);
  const auto redis = Redis::start();
  if (redis) redis->set(std::string(bytes, 'x'));
  for (const int clients : {1, 10, 100}) {
    Asking echoed = gamma_query(daemon, clients, 0);
    echoed.socket = folder.file("echo.sock");
    std::map<std::string, Asking> servers{{"slipd", gamma_query(daemon, clients, 0)}, {"echo", echoed}};
    if (redis)
      servers["redis"] = {.socket = redis->socket(), .request = kRedisGet, .newlines = 2, .clients = clients};
    in_turn(servers, clients, whole / kRounds);
    calls("slipd", daemon.program().pid(), servers.at("slipd"));
    if (redis) calls("redis", redis->pid(), servers.at("redis"));
  }
  for (const int subscribers : {1, 10, 100}) {
    const Asked asked = ask_for(gamma_query(daemon, 10, subscribers), whole / 2);
    json values = to_json(asked);
    values.update({{"server", "slipd"},
                   {"clients", 10},
                   {"subscribers", subscribers},
                   {"heard_per_s", static_cast<double>(asked.heard) /
                                       std::chrono::duration<double>(whole / 2 + 100ms).count()}});
    say("queries", values);
  }
}

void redis_startup() {
  std::vector<std::int64_t> times;
  for (int i = 0; i < (brief ? 2 : 12); ++i) {
    const std::int64_t begun = now_ns();
    const auto redis = Redis::start();
    if (!redis) return;
    times.push_back(now_ns() - begun);
  }
  json values = bench::to_json(quantiles_of(times));
  values["method"] = "redis";
  say("startup", values);
}

}  // namespace slipd::bench
