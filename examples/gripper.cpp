// A gripper's loop in C++, on slipd's socket: gripper SENSOR [SOCKET [GRIP_INPUT]]
// Prints a line for each change of state or force. GRIP_INPUT: datagram socket of a simulated sensor.
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <slipd.hpp>
#include <string>

namespace {

constexpr double kFirmN = 6;        // without a margin: holds each object, breaks none
constexpr double kMostN = 8;        // what no object is harmed by
constexpr double kShareMore = 1.1;  // on an alert without advice
constexpr double kMaxAgeS = 0.1;    // some frames, and less than the time in which an object slips

volatile std::sig_atomic_t ended = 0;

// Replace this with your gripper's command.
void command(double force_n, const std::string& grip_input) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (grip_input.empty() || grip_input.size() >= sizeof address.sun_path) return;
  grip_input.copy(address.sun_path, grip_input.size());
  const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const std::string text = std::to_string(force_n);
  sendto(fd, text.data(), text.size(), MSG_DONTWAIT, reinterpret_cast<const sockaddr*>(&address),
         sizeof address);
  close(fd);
}

// The force after an estimate. It never lets go by itself: when to do so depends on the task.
double next_force(double force_n, const slipd::client::Estimate& now) {
  const slipd_estimate& fields = now.fields();
  if (fields.state != SLIPD_STATE_OK || fields.alert == SLIPD_ALERT_UNKNOWN)
    force_n = std::max(force_n, kFirmN);
  if (fields.alert != SLIPD_ALERT_WARN && fields.alert != SLIPD_ALERT_SLIP) return force_n;
  const double more_n = std::isfinite(fields.grip_increase_n) ? fields.grip_increase_n : 0;
  return std::min(kMostN, std::max(force_n + more_n, force_n * kShareMore));
}

int run(const std::string& sensor, const std::string& socket, const std::string& grip_input) {
  slipd::client::Connection slipd(socket);
  slipd.subscribe(sensor);
  double force_n = kFirmN;
  int state = -1, alert = -1;
  while (ended == 0) {
    // The next estimate, or after kMaxAgeS none: its state is then stale or disconnected.
    const auto now = slipd.next(kMaxAgeS, kMaxAgeS);
    const double wanted_n = next_force(force_n, now);
    if (wanted_n != force_n || now.fields().state != state || now.fields().alert != alert) {
      std::printf("%s %s margin %.3f force %.2f N\n", slipd_state_name(now.fields().state),
                  slipd_alert_name(now.fields().alert), now.margin().value_or(NAN), wanted_n);
      std::fflush(stdout);
    }
    force_n = wanted_n;
    state = now.fields().state;
    alert = now.fields().alert;
    command(force_n, grip_input);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: gripper SENSOR [SOCKET [GRIP_INPUT]]\n"), 2;
  std::signal(SIGTERM, [](int) { ended = 1; });
  std::signal(SIGINT, [](int) { ended = 1; });
  try {
    return run(argv[1], argc > 2 ? argv[2] : SLIPD_SOCKET, argc > 3 ? argv[3] : "");
  } catch (const slipd::client::Error& error) {
    return std::fprintf(stderr, "gripper: %s\n", error.what()), 1;
  }
}
