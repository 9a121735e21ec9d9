/* conformance-c SOCKET: libslipd under conformance_test.py. Reads one command a line, prints one JSON object a line:
 *   gamma NAME MAX_AGE_S TIMEOUT_S   grasp NAME MAX_AGE_S TIMEOUT_S   the request
 *   latest NAME MAX_AGE_S                                             from shared memory, attached when it has to be
 *   subscribe NAME MAX_AGE_S   next                                   estimates as they come
 * "code": done; timeout; disconnected (there is no slipd); refused (or no such name). */
#include <math.h>
#include <slipd.h>
#include <stdio.h>
#include <string.h>

static const double kAttachTimeoutS = 1;
static const double kSubscribeTimeoutS = 300; /* on a busy machine */

static const char *code_name(int code) {
  switch (code) {
    case SLIPD_DONE:
      return "done";
    case SLIPD_TIMEOUT:
      return "timeout";
    case SLIPD_DISCONNECTED:
    case SLIPD_ATTACH_ANEW:
      return "disconnected";
    case SLIPD_REFUSED:
    case SLIPD_INVALID:
      return "refused";
    default:
      return "failed";
  }
}

/* As on the socket; an alert's cause is never "none". */
static const char *cause_name(int cause) {
  switch (cause) {
    case SLIPD_CAUSE_NONE:
      return "null";
    case SLIPD_CAUSE_MARGIN:
      return "\"margin\"";
    case SLIPD_CAUSE_SLIDING:
      return "\"sliding\"";
    default:
      return "\"unknown\"";
  }
}

static void print_number(const char *key, double value) {
  if (isfinite(value)) {
    printf(",\"%s\":%.17g", key, value);
  } else {
    printf(",\"%s\":null", key);
  }
}

static void print(int code, const struct slipd_estimate *now) {
  printf("{\"code\":\"%s\",\"name\":\"%s\",\"state\":\"%s\",\"alert\":\"%s\"", code_name(code), now->name,
         slipd_state_name(now->state), slipd_alert_name(now->alert));
  printf(",\"alert_cause\":%s", cause_name(now->alert_cause));
  printf(",\"seq\":%llu,\"dropped\":%llu,\"simulated\":%s", (unsigned long long)now->sequence,
         (unsigned long long)now->dropped, now->simulated ? "true" : "false");
  print_number("gamma", slipd_margin(now));
  print_number("gamma_low", now->gamma_low);
  print_number("normal_n", now->normal_n);
  print_number("shear_n", now->shear_n);
  print_number("age_s", now->age_s);
  puts("}");
  fflush(stdout);
}

static int latest(slipd_client *slipd, const char *name, double max_age_s, struct slipd_estimate *now) {
  int code = slipd_latest(slipd, name, max_age_s, now);
  if (code == SLIPD_ATTACH_ANEW && slipd_attach(slipd, NULL, kAttachTimeoutS) == SLIPD_DONE)
    code = slipd_latest(slipd, name, max_age_s, now);
  return code;
}

int main(int argc, char **argv) {
  slipd_client *slipd = NULL;
  struct slipd_estimate now;
  char line[256], verb[32], name[64];
  double subscribed_age_s = 0;
  if (argc != 2 || slipd_open(&slipd, argv[1]) != SLIPD_DONE) return 2;
  while (fgets(line, sizeof line, stdin) != NULL) {
    double max_age_s = 0, timeout_s = 0;
    int code = SLIPD_INVALID;
    memset(&now, 0, sizeof now);
    now.gamma = now.gamma_low = now.normal_n = now.shear_n = now.age_s = NAN;
    name[0] = 0;
    if (sscanf(line, "%31s %63s %lf %lf", verb, name, &max_age_s, &timeout_s) < 1) continue;
    if (strcmp(verb, "gamma") == 0) {
      code = slipd_gamma(slipd, name, max_age_s, timeout_s, &now);
    } else if (strcmp(verb, "grasp") == 0) {
      code = slipd_grasp(slipd, name, max_age_s, timeout_s, &now);
    } else if (strcmp(verb, "latest") == 0) {
      code = latest(slipd, name, max_age_s, &now);
    } else if (strcmp(verb, "subscribe") == 0) {
      subscribed_age_s = max_age_s;
      code = slipd_subscribe(slipd, name, 0, SLIPD_EVENT_ESTIMATE, kSubscribeTimeoutS);
    } else if (strcmp(verb, "next") == 0) {
      code = slipd_next(slipd, subscribed_age_s, subscribed_age_s, &now);
    } else {
      return fprintf(stderr, "conformance: what is %s?\n", verb), 2;
    }
    print(code, &now);
  }
  slipd_close(slipd);
  return 0;
}
