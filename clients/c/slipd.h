/* libslipd: the safety margin of slipd's sensors in programs in C. libslipd(3) describes it; slipd.hpp is the same
 * for C++.
 *
 *   slipd_client *s = NULL;
 *   if (slipd_open(&s, NULL) != SLIPD_DONE) return 1;
 *   if (slipd_attach(s, "left", 1.0) != SLIPD_DONE) puts(slipd_error_text(s));
 *   struct slipd_estimate now;
 *   for (;;) {
 *     slipd_wait(s, "left", 0.02, 0.01, &now);      // the next estimate, or 20 ms; none older than 10 ms
 *     command(now.state == SLIPD_STATE_OK ? now.grip_increase_n : hold_firmly());
 *   }
 *
 * A margin is a number in state SLIPD_STATE_OK only, and only while it is younger than the age that the caller
 * gives. Whatever a function returns, it has filled `estimate`: if it has no estimate, gamma is NaN and the state
 * is SLIPD_STATE_STALE or SLIPD_STATE_DISCONNECTED.
 *
 * Threads: the library starts none. A `slipd_client` belongs to one thread at a time; several may be open. Functions for
 * the shared memory allocate nothing. No function throws, exits or writes to the terminal.
 */
#ifndef SLIPD_H
#define SLIPD_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default) /* all else in the library is hidden */

#define SLIPD_SOCKET "/run/slipd/slipd.sock"

/* A connection to slipd, and its shared memory if it is attached. */
typedef struct slipd_client slipd_client;

/* What functions return. Errors are negative; slipd_error_text() says more. */
enum {
  SLIPD_DONE = 0,             /* it was done */
  SLIPD_TIMEOUT = 1,          /* nothing came in time */
  SLIPD_DISCONNECTED = -1,    /* slipd does not run, has gone, or may not be used */
  SLIPD_REFUSED = -2,         /* slipd refused the request */
  SLIPD_INVALID = -3,         /* an argument is not valid, or there is no such name */
  SLIPD_NO_MEMORY = -4,       /* there is no memory left */
  SLIPD_ATTACH_ANEW = -5      /* slipd has stopped or was reloaded: call slipd_attach again */
};

/* Why there is a margin, or none: the first eight are slipd's own. */
enum {
  SLIPD_STATE_OK = 0,
  SLIPD_STATE_NO_CONTACT = 1,
  SLIPD_STATE_LEARNING = 2,
  SLIPD_STATE_OUT_OF_MODEL = 3,
  SLIPD_STATE_NO_SHEAR = 4,
  SLIPD_STATE_UNZEROED = 5,
  SLIPD_STATE_STALE = 6,        /* also: older than the caller allows */
  SLIPD_STATE_FAULT = 7,
  SLIPD_STATE_DISCONNECTED = 8  /* of the library: there is no slipd */
};

/* NONE: slipd watches, and there is no alert. UNKNOWN: nobody watches: no frames, no slipd, or neither a margin nor a
 * pattern that shows slides. An alert that was raised stands until frames show its end. */
enum { SLIPD_ALERT_NONE = 0, SLIPD_ALERT_WARN = 1, SLIPD_ALERT_SLIP = 2, SLIPD_ALERT_UNKNOWN = 3 };
/* Why there is an alert: the margin is small, or the object slides whatever the margin. NONE: there is no alert. */
enum { SLIPD_CAUSE_NONE = 0, SLIPD_CAUSE_MARGIN = 1, SLIPD_CAUSE_SLIDING = 2, SLIPD_CAUSE_UNKNOWN = 255 };
enum { SLIPD_SLIDING_NONE = 0, SLIPD_SLIDING_DISTURBED = 1, SLIPD_SLIDING_TRANSLATION = 2,
       SLIPD_SLIDING_ROTATION = 3, SLIPD_SLIDING_UNKNOWN = 255 };
/* Bits of `events` of slipd_subscribe(). */
enum { SLIPD_EVENT_ESTIMATE = 1, SLIPD_EVENT_ALERT = 2, SLIPD_EVENT_STATE = 4 };

/* What slipd says of a sensor or of a grasp. Unknown numbers are NaN. */
struct slipd_estimate {
  char name[64];                /* of the sensor or grasp */
  int32_t state;                /* SLIPD_STATE_… when the function returned */
  int32_t alert;                /* SLIPD_ALERT_…; of an estimate that is too old WARN, SLIP or UNKNOWN */
  int32_t sliding;              /* SLIPD_SLIDING_… */
  int32_t event;                /* SLIPD_EVENT_…, of slipd_next */
  int32_t simulated;            /* 1: of a simulated sensor */
  int32_t alert_cause;          /* SLIPD_CAUSE_…; an older libslipd leaves NONE, also with an alert: unknown */
  uint64_t sequence;            /* of the frame */
  uint64_t dropped;             /* estimates of this name that did not reach the caller just before this one */
  int64_t time_ns;              /* of the sample, CLOCK_MONOTONIC; 0: there was no frame */
  double age_s;                 /* age of the sample when the function returned; infinite: no frame */
  double gamma;                 /* safety margin, 0 (slips) to 1 (no tangential load); NaN unless state is OK */
  double sigma;                 /* its standard deviation */
  double gamma_low;             /* the margin that holds with 95 % confidence while friction stays; NaN if too old */
  double friction;              /* coefficient */
  double friction_sigma;
  double normal_n;              /* normal force, N */
  double shear_n;               /* tangential force, N */
  double torque_nm;             /* about the contact's normal, N m */
  double torque_sigma_nm;
  double center_x_m, center_y_m, radius_m;
  double time_to_slip_s;        /* forecast */
  double grip_increase_n;       /* force to add for the configured target margin, N; NaN if too old */
  double grip_increase_sigma_n;
  double sliding_for_s;
  int64_t valid_until_ns;       /* CLOCK_MONOTONIC at which it becomes older than allowed; see slipd_margin() */
  double shear_x_n, shear_y_n;  /* components of shear_n along the sensor's x and y, N; NaN: of a grasp, and in
                                   shared memory, which does not have them */
  int64_t realtime_ns;          /* of the sample, CLOCK_REALTIME, as slipd sent it; 0: there was no frame, or of shared
                                   memory, which has time_ns only */
  double reserved[5];
};

/* Of the library, "0.2.0". */
const char *slipd_version(void);

/* Makes `*out` for the socket `path` (NULL: SLIPD_SOCKET). Connects to nothing yet; every function that needs the
 * connection makes it, and makes it again after it was lost. Returns SLIPD_DONE or SLIPD_NO_MEMORY, and sets `*out` to
 * NULL then. */
int slipd_open(slipd_client **out, const char *path);
/* Connects, within timeout_s. Other functions do so by themselves. */
int slipd_connect(slipd_client *s, double timeout_s);
/* Ends everything; NULL is allowed. */
void slipd_close(slipd_client *s);
/* For people: what the last error was and what to do; "" after success. Valid until the next call. */
const char *slipd_error_text(const slipd_client *s);

/* The margin of an estimate now: NaN unless its state is OK and it is still as young as was allowed. For a program
 * that keeps an estimate. */
double slipd_margin(const struct slipd_estimate *estimate);
/* As on the socket: "ok", "no_contact", …, "disconnected"; "none", "warn", "slip", "unknown".
 * "?" for other numbers. */
const char *slipd_state_name(int state);
const char *slipd_alert_name(int alert);

/* --- By the socket: requests. timeout_s: of the whole call. max_age_s: older estimates are stale. --------------- */

/* The latest estimate of a sensor. */
int slipd_gamma(slipd_client *s, const char *sensor, double max_age_s, double timeout_s, struct slipd_estimate *estimate);
/* The latest estimate of a grasp: as old as its oldest sensor. */
int slipd_grasp(slipd_client *s, const char *grasp, double max_age_s, double timeout_s, struct slipd_estimate *estimate);
/* Any method of docs/socket.md: `params` and `*result` are JSON text; params NULL: none. `descriptor`: -1; slipd takes
 * none any more, and another value is SLIPD_INVALID. The result is freed by slipd_free(). */
int slipd_call(slipd_client *s, const char *method, const char *params, int descriptor, double timeout_s, char **result);
/* Lists of docs/socket.md as JSON text; freed by slipd_free(). */
int slipd_sensors(slipd_client *s, double timeout_s, char **result);
int slipd_status(slipd_client *s, double timeout_s, char **result);
int slipd_frame(slipd_client *s, const char *sensor, double timeout_s, char **result);
/* Records a sensor's frames for `seconds`, at most 86400, into `fd`, which is open for writing and stays the caller's.
 * Returns when the recording has ended, at most timeout_s after its time. `*result`: what docs/socket.md says of
 * `recorded`, as JSON text; freed by slipd_free(). SLIPD_REFUSED with a `*result`: it ended early, as slipd_error_text()
 * says. SLIPD_INVALID: `fd` takes nothing, as on a full disk. What was written before any error can be read. */
int slipd_record(slipd_client *s, const char *sensor, double seconds, int fd, double timeout_s, char **result);
void slipd_free(char *text);

/* --- By the socket: a subscription. ----------------------------------------------------------------------------- */

/* Estimates as they come, of one sensor, or of all (NULL). max_rate_hz: 0 for all. events: SLIPD_EVENT_… bits. One
 * subscription for each `slipd_client`; another call replaces it. It is made again after slipd was away. */
int slipd_subscribe(slipd_client *s, const char *sensor, double max_rate_hz, int events, double timeout_s);
/* A descriptor for poll() and epoll: readable when slipd_next() has something to do, also to connect again. The same
 * during the life of `s`. Call slipd_next() with timeout_s 0 until it returns no SLIPD_DONE before you poll again: one
 * read may bring several estimates. */
int slipd_fd(const slipd_client *s);
/* The next estimate; waits at most timeout_s (0: not at all). SLIPD_DONE: there is one. SLIPD_TIMEOUT: none.
 * SLIPD_DISCONNECTED: slipd is away; it was said so by this return value and state, once for each attempt to
 * connect: 50 ms after the loss, then after twice the last pause, at most 2 s. Without an estimate `estimate` has the name of
 * the sensor that was subscribed to, if it was one, and its alert if that stands. */
int slipd_next(slipd_client *s, double max_age_s, double timeout_s, struct slipd_estimate *estimate);
/* The estimate that slipd_next() returned last, as slipd sent it: a JSON object of docs/socket.md, which has more
 * than struct slipd_estimate. Its state and age are those when slipd sent it. "" if there is none, or no memory
 * left. Valid until the next call with `s`. */
const char *slipd_event_text(const slipd_client *s);

/* --- By shared memory: no system call to read, one to wait. ----------------------------------------------------- */

/* Maps the board of slipd. `wait_for`: the sensor or grasp that slipd_wait() is called with, which slipd wakes this
 * program for; NULL: none, which costs slipd nothing (slipd_wait() then looks twenty times a second). Call it again
 * after SLIPD_ATTACH_ANEW. If it fails, slipd_latest() and slipd_wait() return SLIPD_ATTACH_ANEW, and alerts that were
 * raised before stand. */
int slipd_attach(slipd_client *s, const char *wait_for, double timeout_s);
/* The latest estimate. Never blocks, no system call. SLIPD_ATTACH_ANEW: there is no memory, slipd has stopped, was
 * reloaded, or its heartbeat is older than max_age_s and ten of its periods: state SLIPD_STATE_DISCONNECTED. */
int slipd_latest(slipd_client *s, const char *name, double max_age_s, struct slipd_estimate *estimate);
/* Waits for an estimate that this function has not returned before, at most timeout_s. SLIPD_DONE: it is new.
 * SLIPD_TIMEOUT: there is none; `estimate` has the last one, judged by its age. */
int slipd_wait(slipd_client *s, const char *name, double max_age_s, double timeout_s, struct slipd_estimate *estimate);
/* Age of slipd's last sign of life, s; infinite if it is not attached, or slipd's clock is ahead of this program's.
 * A running slipd's is below 0.02, more only if its threads get no processor. */
double slipd_heartbeat_age(const slipd_client *s);

/* --- Frames of a sensor from this program, for a sensor whose driver is "push" (docs/push.md). ------------------- */

/* A connection to the socket of one sensor. It belongs to one thread at a time. */
typedef struct slipd_source slipd_source;

/* What the values of frames are; UNSAID: as configured. */
enum { SLIPD_UNIT_UNSAID = 0, SLIPD_UNIT_PA = 1, SLIPD_UNIT_N = 2, SLIPD_UNIT_COUNTS = 3, SLIPD_UNIT_UT = 4, SLIPD_UNIT_MM = 5 };
/* What frames read without load: UNSAID: as configured; MEASURED: anything, slipd measures it; ZERO: 0. */
enum { SLIPD_ZERO_UNSAID = 0, SLIPD_ZERO_MEASURED = 1, SLIPD_ZERO_ZERO = 2 };

/* What the frames are. It has to agree with the configuration. */
struct slipd_frames {
  uint32_t taxels;   /* as many as the sensor's layout has */
  int32_t axes;      /* values of each taxel: 3 (x, y, z; z is positive when pressed) or 1 (z) */
  int32_t unit;      /* SLIPD_UNIT_… */
  int32_t zero;      /* SLIPD_ZERO_… */
  double rate_hz;    /* frames a second; 0: as configured */
};

/* Makes `*out` for the sensor, whose socket is beside slipd's at `path` (NULL: SLIPD_SOCKET); a name with a "/" is the
 * path of the sensor's own socket. Connects to nothing yet. SLIPD_DONE, SLIPD_INVALID or SLIPD_NO_MEMORY; `*out` is
 * NULL then. */
int slipd_source_open(slipd_source **out, const char *sensor, const char *path, const struct slipd_frames *frames);
/* Connects, unless it is connected. slipd_push() does so by itself. SLIPD_REFUSED: the frames contradict the
 * configuration, or another program sends them; slipd_source_error() says which. */
int slipd_source_connect(slipd_source *s, double timeout_s);
/* Sends a frame: taxels x axes values, those of one taxel side by side, in the order of the layout. time_ns: of the
 * sample, CLOCK_MONOTONIC; 0: now. sequence: the device's own count, which must rise, slipd counts what it skips as
 * lost; 0: the next. timeout_s: how long slipd may not read (SLIPD_TIMEOUT; the frame was not sent).
 * SLIPD_DISCONNECTED: slipd has gone; the next call connects again. Allocates nothing. */
int slipd_push(slipd_source *s, const float *values, int64_t time_ns, uint64_t sequence, double timeout_s);
/* For people: what the last error was and what to do; "" after success. Valid until the next call. */
const char *slipd_source_error(const slipd_source *s);
/* Ends everything; NULL is allowed. */
void slipd_source_close(slipd_source *s);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
