// daemon-bench [--brief] [PART…]: the real slipd, from its device to its clients. Prints one JSON object a
// line. Parts: latency, throughput, sensors, queries, startup, memory, idle, can. --brief: a moment each, to
// see that it works.
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <iostream>
#include <map>
#include <set>
#include <thread>

#include "tests/bench/load.hpp"
#include "tests/bench/running.hpp"
#include "tests/bench/scenes.hpp"

namespace slipd::bench {
namespace {

using nlohmann::json;
using testing::Daemon;
using testing::TempFolder;
using namespace std::chrono_literals;
using std::chrono::milliseconds;

bool brief = false;

milliseconds length(milliseconds whole) {
  return brief ? whole / 20 : whole;
}

// Trained ones are left out of a moment's run: training takes longer than that.
std::vector<const char*> methods() {
  if (brief) return {"moments", "fit"};
  return {"moments", "registered", "svd-knn", "fit"};
}

bool left_out(const std::string& method) {
  return brief && (method == "svd-knn" || method == "registered");
}

void say(const char* part, json values) {
  values["part"] = part;
  std::cout << values.dump() << std::endl;
}

json to_json(const Quantiles& of) {
  return {{"p50_us", of.p50_us}, {"p99_us", of.p99_us}, {"p999_us", of.p999_us}, {"max_us", of.max_us}};
}

// The lines of a subscribed connection, and when they were in hand.
class Listener {
 public:
  explicit Listener(const std::filesystem::path& socket) : fd_(connect_to(socket)) {
    const std::string text = R"({"jsonrpc":"2.0","id":1,"method":"subscribe"})"
                             "\n";
    if (send(fd_, text.data(), text.size(), MSG_NOSIGNAL) < 0) throw std::runtime_error("subscribe");
  }
  ~Listener() { close(fd_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  struct Heard {
    std::int64_t time_ns = 0, in_hand_ns = 0;  // CLOCK_REALTIME
  };
  // The next notification of an estimate with a sample's time; none if the server hung up.
  std::optional<Heard> next() {
    for (;;) {
      const auto end = input_.find('\n');
      if (end == std::string::npos) {
        std::array<char, 65536> piece;
        const ssize_t got = recv(fd_, piece.data(), piece.size(), 0);
        if (got <= 0) return std::nullopt;
        arrived_ns_ = std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
        input_.append(piece.data(), static_cast<std::size_t>(got));
        continue;
      }
      const std::string_view line = std::string_view(input_).substr(0, end);
      const auto at = line.find("\"time_ns\":");
      const Heard heard{at == line.npos || line[at + 10] == 'n' ? 0 : std::atoll(line.data() + at + 10),
                        arrived_ns_};
      input_.erase(0, end + 1);
      if (heard.time_ns != 0) return heard;
    }
  }

 private:
  int fd_;
  std::string input_;
  std::int64_t arrived_ns_ = 0;
};

const json& sensor_of(const json& status) {
  return status["sensors"][0];
}

// Frame complete → in a subscribed client's hands, at 1 kHz.
void latency() {
  for (const char* method : methods()) {
    const TempFolder folder;
    const Daemon daemon(config(folder, json::array({trial("left", 100, 1000)}), method),
                        testing::trial_drivers(), state());
    wait_for_estimates(daemon, 100);
    Listener listener(daemon.socket());
    std::vector<std::int64_t> times;
    const std::int64_t until = now_ns() + std::chrono::nanoseconds(length(6s)).count();
    while (now_ns() < until) {
      const auto heard = listener.next();
      if (!heard) break;
      times.push_back(heard->in_hand_ns - heard->time_ns);
    }
    json values = to_json(quantiles_of(times));
    const json status = daemon.client().result("status");
    values.update({{"method", method}, {"frames", times.size()}, {"skipped", sensor_of(status)["skipped"]}});
    say("latency", values);
  }
}

// Frames as fast as the estimator takes them: the device waits for it, none is skipped.
void throughput() {
  for (const char* method : methods()) {
    const TempFolder folder;
    const Daemon daemon(config(folder, json::array({trial("left", 100, 1000, {{"paced", true}})}), method),
                        testing::trial_drivers(), state());
    wait_for_estimates(daemon, 100);
    auto client = daemon.client();
    const auto counts = [&] { return client.result("status")["sensors"][0]; };
    const json before = counts();
    const std::int64_t begun = now_ns();
    std::this_thread::sleep_for(length(2s));
    const json after = counts();
    const double seconds = 1e-9 * static_cast<double>(now_ns() - begun);
    const auto gained = [&](const char* name) {
      return after[name].get<double>() - before[name].get<double>();
    };
    say("throughput", {{"method", method},
                       {"frames_per_s", gained("estimated") / seconds},
                       {"skipped", gained("skipped")}});
  }
}

// Sensors of 16 x 16 at 1 kHz: what each costs, and what it waits.
void sensors() {
  for (const int count : {1, 2, 4, 8, 16}) {
    const TempFolder folder;
    json all = json::array();
    for (int i = 0; i < count; ++i) all.push_back(trial("s" + std::to_string(i), 16, 1000));
    const Daemon daemon(config(folder, all, "moments"), testing::trial_drivers(), state());
    wait_for_estimates(daemon, 100);
    const double before_s = usage_of(daemon.program().pid()).cpu_s;
    const std::int64_t begun = now_ns();
    std::this_thread::sleep_for(length(2s));
    const double seconds = 1e-9 * static_cast<double>(now_ns() - begun);
    const double cpu = (usage_of(daemon.program().pid()).cpu_s - before_s) / seconds;
    const json status = daemon.client().result("status");
    say("sensors", {{"sensors", count},
                    {"cpu", cpu},
                    {"p50_us", sensor_of(status)["latency_us"]["p50"]},
                    {"p99_us", sensor_of(status)["latency_us"]["p99"]},
                    {"skipped", sensor_of(status)["skipped"]}});
  }
}

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
  json values = to_json(asked.waits);
  values.update({{"per_s", asked.per_second}, {"bytes", asked.answer_bytes}});
  return values;
}

// redis-server in the folder, answering on a socket without writing anything to disk; none where it is not
// installed.
std::unique_ptr<testing::Program> redis(const TempFolder& folder) {
  const std::string server = "/usr/bin/redis-server";
  if (!std::filesystem::exists(server)) return nullptr;
  auto made = std::make_unique<testing::Program>(
      folder, "redis",
      std::vector<std::string>{server, "--port", "0", "--unixsocket", folder.file("r.sock").string(),
                               "--save", "", "--appendonly", "no", "--dir", folder.path().string()});
  for (int i = 0; i < 500 && !std::filesystem::exists(folder.file("r.sock")); ++i)
    std::this_thread::sleep_for(10ms);
  std::this_thread::sleep_for(50ms);
  return made;
}

// The run with the median throughput: a machine that others use as well is slower now and then.
const Asked& usual_of(std::vector<Asked>& asked) {
  const auto middle = asked.begin() + static_cast<std::ptrdiff_t>(asked.size() / 2);
  std::nth_element(asked.begin(), middle, asked.end(),
                   [](const Asked& a, const Asked& b) { return a.per_second < b.per_second; });
  return *middle;
}

// `gamma` against GET of a value of the answer's size, by the same clients, in turn.
void queries() {
  constexpr int kRounds = 5;
  const TempFolder folder;
  const Daemon daemon(config(folder, json::array({trial("left", 16, 1000)}), "moments"),
                      testing::trial_drivers(), state());
  wait_for_estimates(daemon, 100);
  const auto whole = length(4s);
  const std::size_t bytes = ask_for(gamma_query(daemon, 1, 0), length(200ms)).answer_bytes;
  const auto peer = redis(folder);
  if (peer) {
    const std::string value(bytes, 'x');
    const std::string set =
        "*3\r\n$3\r\nSET\r\n$1\r\nk\r\n$" + std::to_string(bytes) + "\r\n" + value + "\r\n";
    const int fd = connect_to(folder.file("r.sock"));
    std::array<char, 64> ok{};
    if (send(fd, set.data(), set.size(), 0) < 0 || recv(fd, ok.data(), ok.size(), 0) <= 0)
      throw std::runtime_error("SET");
    close(fd);
  } else {
    say("queries", {{"skipped", "redis-server is not installed"}});
  }
  for (const int clients : {1, 10, 100}) {
    const Asking get{.socket = folder.file("r.sock"),
                     .request = "*2\r\n$3\r\nGET\r\n$1\r\nk\r\n",
                     .newlines = 2,
                     .clients = clients};
    std::vector<Asked> ours, theirs;
    for (int round = 0; round < kRounds; ++round) {
      ours.push_back(ask_for(gamma_query(daemon, clients, 0), whole / kRounds));
      if (peer) theirs.push_back(ask_for(get, whole / kRounds));
    }
    for (const auto& [server, asked] : {std::pair{"slipd", &ours}, std::pair{"redis", &theirs}}) {
      if (asked->empty()) continue;
      json values = to_json(usual_of(*asked));
      values.update({{"server", server}, {"clients", clients}, {"subscribers", 0}});
      say("queries", values);
    }
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

// From the start of the program to the first estimate in a client's hands, its model already on disk.
void startup() {
  for (const auto& [method, side] : {std::pair{"moments", 4}, std::pair{"svd-knn", 100},
                                     std::pair{"registered", 100}, std::pair{"auto", 100}}) {
    if (left_out(method)) continue;
    std::vector<std::int64_t> times;
    for (int i = 0; i < (brief ? 2 : 12); ++i) {
      const TempFolder folder;
      const json all =
          config(folder, json::array({trial("left", static_cast<std::size_t>(side), 1000)}), method);
      const auto file = folder.write("slipd.json", all.dump());
      const std::int64_t begun = now_ns();
      testing::Program program(folder, "slipd",
                               {(testing::program_folder() / "slipd").string(), "--config", file.string(),
                                "--driver-dir", testing::trial_drivers().string()},
                               state());
      std::optional<Listener> listener;
      while (!listener) {
        try {
          listener.emplace(folder.file("s.sock"));
        } catch (const std::system_error&) {
          if (program.wait(1ms)) throw std::runtime_error("slipd has ended: " + program.errors());
        }
      }
      listener->next();
      // The first is of the model's making, that it made the model of: not counted.
      if (i > 0) times.push_back(now_ns() - begun);
      program.signal(SIGTERM);
      program.wait(10s);
    }
    json values = to_json(quantiles_of(times));
    values.update({{"method", method}, {"side", side}});
    say("startup", values);
  }
}

void memory() {
  for (const bool locked : {false, true}) {
    for (const auto& [method, side] :
         {std::pair{"moments", 4}, std::pair{"moments", 100}, std::pair{"svd-knn", 100},
          std::pair{"registered", 100}, std::pair{"fit", 100}}) {
      if (left_out(method)) continue;
      const TempFolder folder;
      const json realtime{{"realtime", {{"mode", locked ? "prefer" : "off"}, {"lock_memory", locked}}}};
      const Daemon daemon(config(folder, json::array({trial("left", static_cast<std::size_t>(side), 1000)}),
                                 method, realtime),
                          testing::trial_drivers(), state());
      wait_for_estimates(daemon, 500);
      const Usage usage = usage_of(daemon.program().pid());
      say("memory", {{"method", method},
                     {"side", side},
                     {"locking", locked},
                     {"resident_mb", usage.resident_mb},
                     {"own_mb", usage.own_mb},
                     {"locked_mb", usage.locked_mb}});
    }
  }
}

// A sensor at 1 kHz that nothing touches: its driver, the search for a contact, and nothing else.
void idle() {
  for (const int side : {4, 100}) {
    const TempFolder folder;
    const json free{{"noise", 0}, {"cycle", {{{"ms", 3600000}, {"normal_n", 0}}}}};
    json sensor = trial("left", static_cast<std::size_t>(side), 1000, free);
    sensor["driver"] = "sim";
    const Daemon daemon(config(folder, json::array({sensor}), "moments"), testing::real_drivers(), state());
    wait_for_estimates(daemon, 200);
    const double before_s = usage_of(daemon.program().pid()).cpu_s;
    const std::int64_t begun = now_ns();
    std::this_thread::sleep_for(length(4s));
    const double seconds = 1e-9 * static_cast<double>(now_ns() - begun);
    say("idle", {{"side", side}, {"cpu", (usage_of(daemon.program().pid()).cpu_s - before_s) / seconds}});
  }
}

int run(const std::set<std::string>& parts) {
  const std::pair<const char*, void (*)()> all[] = {
      {"latency", latency}, {"throughput", throughput}, {"sensors", sensors}, {"queries", queries},
      {"startup", startup}, {"memory", memory},         {"idle", idle}};
  for (const auto& [name, body] : all) {
    if (parts.empty() || parts.count(name) > 0) body();
  }
  return 0;
}

}  // namespace
}  // namespace slipd::bench

int main(int argc, char** argv) try {
  std::set<std::string> parts;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--brief") == 0) {
      slipd::bench::brief = true;
    } else {
      parts.insert(argv[i]);
    }
  }
  return slipd::bench::run(parts);
} catch (const std::exception& error) {
  std::cerr << "daemon-bench: " << error.what() << '\n';
  return 1;
}
