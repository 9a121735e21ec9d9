/* A gripper's loop in C, on slipd's shared memory: gripper SENSOR [SOCKET [GRIP_INPUT]]
 * Prints a line for each change of state or force. GRIP_INPUT: datagram socket of a simulated sensor. */
#include <math.h>
#include <signal.h>
#include <slipd.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

static const double kFirmN = 6;       /* without a margin: holds each object, breaks none */
static const double kMostN = 8;       /* what no object is harmed by */
static const double kShareMore = 1.1; /* on an alert without advice */
static const double kMaxAgeS = 0.1;   /* some frames, and less than the time in which an object slips */

static volatile sig_atomic_t ended = 0;
static void end(int signal) {
  (void)signal;
  ended = 1;
}

/* Replace this with your gripper's command. */
static void command(double force_n, const char* grip_input) {
  struct sockaddr_un address = {.sun_family = AF_UNIX};
  char text[32];
  int fd;
  if (grip_input == NULL || strlen(grip_input) >= sizeof address.sun_path) return;
  strcpy(address.sun_path, grip_input);
  fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  snprintf(text, sizeof text, "%.3f", force_n);
  sendto(fd, text, strlen(text), MSG_DONTWAIT, (const struct sockaddr*)&address, sizeof address);
  close(fd);
}

/* The force after an estimate. It never lets go by itself: when to do so depends on the task. */
static double next_force(double force_n, const struct slipd_estimate* now) {
  if (now->state != SLIPD_STATE_OK || now->alert == SLIPD_ALERT_UNKNOWN) force_n = fmax(force_n, kFirmN);
  if (now->alert != SLIPD_ALERT_WARN && now->alert != SLIPD_ALERT_SLIP) return force_n;
  const double more_n = isfinite(now->grip_increase_n) ? now->grip_increase_n : 0;
  return fmin(kMostN, fmax(force_n + more_n, force_n * kShareMore));
}

int main(int argc, char** argv) {
  if (argc < 2) return fprintf(stderr, "usage: gripper SENSOR [SOCKET [GRIP_INPUT]]\n"), 2;
  const char* grip_input = argc > 3 ? argv[3] : NULL;
  slipd_client* slipd = NULL;
  if (slipd_open(&slipd, argc > 2 ? argv[2] : NULL) != SLIPD_DONE) return 1;
  if (slipd_attach(slipd, argv[1], 1.0) != SLIPD_DONE)
    return fprintf(stderr, "gripper: %s\n", slipd_error_text(slipd)), 1;
  signal(SIGTERM, end);
  signal(SIGINT, end);
  double force_n = kFirmN;
  int state = -1, alert = -1;
  struct slipd_estimate now;
  while (!ended) {
    /* Waits for the next estimate, for at most the age that is allowed; fills `now` in any case. */
    const int code = slipd_wait(slipd, argv[1], kMaxAgeS, kMaxAgeS, &now);
    if (code == SLIPD_INVALID) return fprintf(stderr, "gripper: %s\n", slipd_error_text(slipd)), 1;
    const double wanted_n = next_force(force_n, &now);
    if (wanted_n != force_n || now.state != state || now.alert != alert) {
      printf("%s %s margin %.3f force %.2f N\n", slipd_state_name(now.state), slipd_alert_name(now.alert),
             slipd_margin(&now), wanted_n);
      fflush(stdout);
    }
    force_n = wanted_n;
    state = now.state;
    alert = now.alert;
    command(force_n, grip_input);
    if (code == SLIPD_ATTACH_ANEW && slipd_attach(slipd, argv[1], kMaxAgeS) != SLIPD_DONE) usleep(50000);
  }
  slipd_close(slipd);
  return 0;
}
