// daemon-bench [--brief] [PART…]: the real slipd, from its device to its clients. Prints one JSON object a
// line. Parts: latency, throughput, sensors, queries, startup, memory, idle, shared, push, each with its
// floors; and, if they are named, growth and growth-goals (tools/growth), and stressed.
// --brief: each for a moment only, as a test of the program.
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

#include "tests/bench/daemon_parts.hpp"
#include "tests/bench/floors.hpp"
#include "tests/bench/load.hpp"
#include "tests/bench/running.hpp"
#include "tests/bench/scenes.hpp"

namespace slipd::bench {

bool brief = false;

std::chrono::milliseconds length(std::chrono::milliseconds whole) {
  return brief ? whole / 20 : whole;
}

void say(const char* part, json values) {
  values["part"] = part;
  std::cout << values.dump() << std::endl;
}

json to_json(const Quantiles& of) {
  return {{"p50_us", of.p50_us}, {"p99_us", of.p99_us}, {"p999_us", of.p999_us}, {"max_us", of.max_us}};
}

namespace {

using testing::Daemon;
using testing::TempFolder;
using namespace std::chrono_literals;

// --brief leaves out trained methods, because training takes too long.
std::vector<const char*> methods() {
  if (brief) return {"moments", "fit"};
  return {"moments", "registered", "svd-knn", "fit"};
}

bool left_out(const std::string& method) {
  return brief && (method == "svd-knn" || method == "registered");
}

// The lines of a subscribed connection, and when each was received.
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

void say_floor(const char* name, const Quantiles& times, json more = json::object()) {
  more.update(to_json(times));
  more["name"] = name;
  say("floor", more);
}

// From a complete frame to its estimate at a subscribed client, at 1 kHz.
void latency() {
  for (const char* method : methods()) {
    say_floor("frame to client", frame_to_client(length(3s)), {{"method", method}});
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
  say_floor("futex wake", futex_wake(length(1s)));
  say_floor("frame there and back", frame_there_and_back(length(1s)));
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

// Sensors of 16 x 16 at 1 kHz: CPU time and latency of each.
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

// From the start of the program to the first estimate at a client, with the model already on disk.
void startup() {
  redis_startup();
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
      // The first run trains the model and is not counted.
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

// A sensor at 1 kHz without contact: the costs of its driver and of the search for a contact.
void idle() {
  for (const int side : {4, 100}) {
    say("floor",
        {{"name", "two threads at 1 kHz"}, {"side", side}, {"cpu", two_threads_at_1_khz(length(4s))}});
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
      {"latency", latency}, {"throughput", throughput}, {"sensors", sensors},
      {"queries", queries}, {"startup", startup},       {"memory", memory},
      {"idle", idle},       {"shared", shared},         {"push", push}};
  for (const auto& [name, body] : all) {
    if (parts.empty() || parts.count(name) > 0) body();
  }
  if (parts.count("growth") > 0) growth();
  if (parts.count("growth-goals") > 0) growth_goals();
  if (parts.count("stressed") > 0) stressed();
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
