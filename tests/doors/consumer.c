/* door-consumer DOOR SOCKET MAX_AGE_S NAME: what a program on libslipd is told of a sensor, as lines of JSON. DOOR: `memory`, which calls
 * slipd_latest 200 times a second, or `subscription`, which calls slipd_next. One thread, as a gripper's loop has it. */
#include <math.h>
#include <slipd.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static const struct timespec kPause = {0, 5000000};
/* While slipd is away: how long one attempt to attach may hold the loop, s, and the calls from one to the next. */
static const double kAttachS = 0.005;
static const int kAttachEvery = 20;

static void tell(const struct slipd_estimate *now) {
  struct timespec clock;
  const double gamma = slipd_margin(now);
  clock_gettime(CLOCK_MONOTONIC, &clock);
  printf("{\"t\":%.6f,\"state\":\"%s\",\"alert\":\"%s\",\"gamma\":", (double)clock.tv_sec + 1e-9 * (double)clock.tv_nsec,
         slipd_state_name(now->state), slipd_alert_name(now->alert));
  if (isnan(gamma))
    printf("null}\n");
  else
    printf("%.4f}\n", gamma);
  fflush(stdout);
}

int main(int argc, char **argv) {
  double max_age_s = 0;
  if (argc != 5 || sscanf(argv[3], "%lf", &max_age_s) != 1) return 2;
  const int by_memory = strcmp(argv[1], "memory") == 0;
  slipd_client *slipd = NULL;
  struct slipd_estimate now;
  if (slipd_open(&slipd, argv[2]) != SLIPD_DONE) return 1;
  if (!by_memory && slipd_subscribe(slipd, argv[4], 0, SLIPD_EVENT_ESTIMATE, 1) != SLIPD_DONE)
    return fprintf(stderr, "door-consumer: %s\n", slipd_error_text(slipd)), 1;
  for (int round = 0;; ++round) {
    if (by_memory) {
      const int code = slipd_latest(slipd, argv[4], max_age_s, &now);
      if (code == SLIPD_ATTACH_ANEW && round % kAttachEvery == 0) slipd_attach(slipd, NULL, kAttachS);
      nanosleep(&kPause, NULL);
    } else {
      slipd_next(slipd, max_age_s, max_age_s, &now);
    }
    tell(&now);
  }
}
