/* A gripper's loop in C, on slipd's CAN frames: gripper-can INTERFACE BASE_ID NUMBER PERIOD_MS [GRIP_INPUT]
 * as in: gripper-can can0 5A0 0 10. NUMBER: of the sensor or grasp in slipd's configuration, sensors first.
 * GRIP_INPUT: datagram socket of a simulated sensor. Needs only the kernel's SocketCAN and slip_can.h. Prints
 * a line for each change of state or force. */
#include <errno.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <math.h>
#include <net/if.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "slip_can.h"

static const double kFirmN = 6;       /* without a margin: holds each object, breaks none */
static const double kMostN = 8;       /* what no object is harmed by */
static const double kShareMore = 1.1; /* on an alert without advice */

static volatile sig_atomic_t ended = 0;
static void end(int signal) {
  (void)signal;
  ended = 1;
}

static double clock_s(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
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

/* A socket for the three messages of this sensor; -1: the interface is absent, and errno says why. */
static int open_bus(const char* interface, const struct slip_can* slip) {
  const canid_t ids[] = {slip->base_id + slip->number, slip->base_id + 0x20 + slip->number,
                         slip->base_id + 0x3F};
  struct can_filter only[3];
  const struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(interface)};
  const int bus = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
  if (bus < 0) return -1;
  for (int i = 0; i < 3; ++i) {
    only[i].can_id = ids[i] | (slip->base_id > CAN_SFF_MASK ? CAN_EFF_FLAG : 0);
    only[i].can_mask = CAN_EFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG;
  }
  if (address.can_ifindex != 0 && setsockopt(bus, SOL_CAN_RAW, CAN_RAW_FILTER, only, sizeof only) == 0 &&
      bind(bus, (const struct sockaddr*)&address, sizeof address) == 0)
    return bus;
  close(bus);
  return -1;
}

/* Reads all pending frames: the first one in the queue can be old. Returns SLIP_CAN_HEARD_… of all; closes a
 * bus that is gone. */
static int hear_all(int* bus, struct slip_can* slip) {
  struct can_frame frame;
  int heard = 0;
  for (;;) {
    const ssize_t got = *bus < 0 ? 0 : recv(*bus, &frame, sizeof frame, MSG_DONTWAIT);
    if (got == (ssize_t)sizeof frame) {
      heard |= slip_can_hear(slip, frame.can_id & CAN_EFF_MASK, frame.data, frame.can_dlc, clock_s());
    } else if (got < 0 && errno == ENODEV) {
      close(*bus);
      *bus = -1;
    } else if (got >= 0 || errno != EINTR) {
      return heard; /* no more frames, or the interface is down, which ends the margin by silence */
    }
  }
}

/* The next force. It never lets go by itself: when to do so depends on the task. */
static double next_force(double force_n, const struct slip_can_reading* now, int heard) {
  const int raised = now->alert == SLIP_CAN_WARN || now->alert == SLIP_CAN_SLIP;
  if (now->state != SLIP_CAN_OK || now->alert == SLIP_CAN_UNKNOWN) force_n = fmax(force_n, kFirmN);
  if (!raised || (heard & SLIP_CAN_HEARD_ALERT) == 0) return force_n;
  const double more_n = isfinite(now->grip_increase_n) ? now->grip_increase_n : 0;
  return fmin(kMostN, fmax(force_n + more_n, force_n * kShareMore));
}

static const char* state_name(int state) {
  static const char* const kNames[] = {"ok",       "no_contact", "learning", "out_of_model",
                                       "no_shear", "unzeroed",   "stale",    "fault"};
  return state >= 0 && state <= SLIP_CAN_FAULT ? kNames[state] : "fault";
}

static const char* alert_name(int alert) {
  static const char* const kNames[] = {"none", "warn", "slip", "unknown"};
  return alert >= 0 && alert <= SLIP_CAN_UNKNOWN ? kNames[alert] : "slip";
}

int main(int argc, char** argv) {
  if (argc < 5)
    return fprintf(stderr, "usage: gripper-can INTERFACE BASE_ID NUMBER PERIOD_MS [GRIP_INPUT]\n"), 2;
  const char* grip_input = argc > 5 ? argv[5] : NULL;
  struct slip_can slip = slip_can_begin((uint32_t)strtoul(argv[2], NULL, 16), (unsigned)atoi(argv[3]),
                                        1e-3 * strtod(argv[4], NULL));
  slip.accept_simulated = grip_input != NULL;
  int bus = open_bus(argv[1], &slip);
  if (bus < 0) return perror(argv[1]), 1;
  signal(SIGTERM, end);
  signal(SIGINT, end);
  double force_n = kFirmN;
  int state = -1, alert = -1;
  while (!ended) {
    struct pollfd frames = {.fd = bus, .events = POLLIN};
    poll(&frames, 1, (int)(1e3 * slip.period_s) + 1);
    if (bus < 0) bus = open_bus(argv[1], &slip); /* the adapter was pulled out: perhaps it is back */
    const int heard = hear_all(&bus, &slip);
    const struct slip_can_reading now = slip_can_now(&slip, clock_s());
    const double wanted_n = next_force(force_n, &now, heard);
    if (wanted_n != force_n || now.state != state || now.alert != alert) {
      printf("%s %s margin %.3f force %.2f N\n", state_name(now.state), alert_name(now.alert), now.gamma,
             wanted_n);
      fflush(stdout);
    }
    force_n = wanted_n;
    state = now.state;
    alert = now.alert;
    command(force_n, grip_input);
  }
  if (bus >= 0) close(bus);
  return 0;
}
