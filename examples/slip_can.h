/* The margin of one sensor or grasp from slipd's CAN frames, by the rules for receivers of docs/can.md. It uses no socket, no
 * clock and no allocation, so that it runs on a microcontroller and can be tested with recorded frames. C11 or C++20.
 *
 *   struct slip_can slip = slip_can_begin(0x5A0, 0, 0.010);   // base_id, number, period_s of slipd's section can
 *   for each frame of the bus:  heard = slip_can_hear(&slip, id, data, length, now_s);
 *   in each cycle:              now = slip_can_now(&slip, now_s);
 */
#ifndef SLIP_CAN_H
#define SLIP_CAN_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

enum { SLIP_CAN_OK = 0, SLIP_CAN_STALE = 6, SLIP_CAN_FAULT = 7 };  /* State; those between have no margin either */
enum { SLIP_CAN_NONE = 0, SLIP_CAN_WARN = 1, SLIP_CAN_SLIP = 2, SLIP_CAN_UNKNOWN = 3 };  /* Alert */
enum { SLIP_CAN_HEARD_ESTIMATE = 1, SLIP_CAN_HEARD_ALERT = 2, SLIP_CAN_HEARD_HEARTBEAT = 4 };
enum { SLIP_CAN_PERIODS = 3 };  /* of silence end a margin; then as many frames are ignored */

/* What may be used now. */
struct slip_can_reading {
  int state;              /* 0 ok; all others: no margin. 6 also: nothing valid came for three periods */
  int alert;              /* SLIP_CAN_NONE does not mean a safe grip; a raised one stands in silence */
  double gamma;           /* safety margin, 0 … 1; NaN unless state is ok */
  double grip_increase_n; /* of the last alert: force to add, N; NaN: unknown */
};

/* A receiver. Set accept_simulated for tests only: no machine may act on a simulated sensor. */
struct slip_can {
  uint32_t base_id;
  unsigned number;     /* of the sensor or grasp in the configuration: sensors first, then grasps */
  double period_s;     /* between two estimates */
  bool accept_simulated;
  int counters[3];     /* of the last estimate, alert, heartbeat; -1: there was none */
  double heard_s;      /* when the last valid estimate came; negative: never */
  int to_ignore;       /* estimates that may be old */
  struct slip_can_reading last;
};

static inline struct slip_can slip_can_begin(uint32_t base_id, unsigned number, double period_s) {
  struct slip_can s = {base_id, number, period_s, false, {-1, -1, -1}, -1, 0, {SLIP_CAN_STALE, SLIP_CAN_UNKNOWN, NAN, NAN}};
  return s;
}

/* SAE J1850, of the identifier without flags and the first seven bytes. */
static inline unsigned slip_can_crc8(uint32_t id, const uint8_t *data) {
  unsigned crc = 0xFF;
  for (int i = 0; i < 11; ++i) {
    crc ^= i < 4 ? id >> 8 * i & 0xFF : data[i - 4];
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x80 ? crc << 1 ^ 0x1D : crc << 1) & 0xFF;
  }
  return crc ^ 0xFF;
}

/* Rule 3: whether nothing valid came for three periods. */
static inline bool slip_can_silent(const struct slip_can *s, double now_s) {
  const int periods = SLIP_CAN_PERIODS;
  return s->heard_s < 0 || now_s - s->heard_s > periods * s->period_s;
}

/* Rules 1 and 2: undamaged, and not a repetition. */
static inline bool slip_can_is_new(int *counter, uint32_t id, const uint8_t *data, unsigned length) {
  if (length != 8 || slip_can_crc8(id, data) != data[7]) return false;
  const int now = data[6] >> 4;
  if (now == *counter) return false;
  *counter = now;
  return true;
}

/* Rules 3 to 5: without margins nobody watches for alerts, but a raised one stands. */
static inline void slip_can_take_away(struct slip_can_reading *now) {
  now->state = SLIP_CAN_STALE;
  now->gamma = NAN;
  if (now->alert == SLIP_CAN_NONE) now->alert = SLIP_CAN_UNKNOWN;
}

static inline void slip_can_estimate(struct slip_can *s, const uint8_t *d, double now_s) {
  const int state = d[4] & 0x0F;
  const unsigned gamma = d[0] + 256U * d[1];
  /* Rule 3: after a silence frames may have waited while the bus was interrupted. */
  if (slip_can_silent(s, now_s)) s->to_ignore = SLIP_CAN_PERIODS;
  s->heard_s = now_s;
  s->last.alert = d[4] >> 4 & 0x03;
  /* Rules 4 and 7: a number in state ok only; an unknown state is a fault. */
  s->last.state = state > SLIP_CAN_FAULT ? SLIP_CAN_FAULT : state;
  s->last.gamma = state == SLIP_CAN_OK && gamma <= 10000 ? 1e-4 * gamma : NAN;
  if (state == SLIP_CAN_OK && gamma > 10000) s->last.state = SLIP_CAN_FAULT;
  if (s->to_ignore == 0) return;
  --s->to_ignore;
  slip_can_take_away(&s->last);
}

/* For each frame of the bus, also those of others. `id`: without flags; no remote and no error frames. now_s: of a clock that is
 * never set. Returns what was heard, SLIP_CAN_HEARD_…; 0: nothing that counts. */
static inline int slip_can_hear(struct slip_can *s, uint32_t id, const uint8_t *data, unsigned length, double now_s) {
  if (id == s->base_id + s->number) {
    if (!slip_can_is_new(&s->counters[0], id, data, length) || ((data[4] & 0x40) != 0 && !s->accept_simulated)) return 0;
    slip_can_estimate(s, data, now_s);
    return SLIP_CAN_HEARD_ESTIMATE;
  }
  if (id == s->base_id + 0x20 + s->number) { /* rule 6: at once, before the next estimate */
    const unsigned increase = data[2] + 256U * data[3];
    if (!slip_can_is_new(&s->counters[1], id, data, length) || ((data[6] & 0x04) != 0 && !s->accept_simulated)) return 0;
    s->last.alert = data[6] & 0x03;
    s->last.grip_increase_n = increase == 0xFFFF ? NAN : 0.01 * increase;
    return SLIP_CAN_HEARD_ALERT;
  }
  if (id == s->base_id + 0x3F) {
    if (!slip_can_is_new(&s->counters[2], id, data, length)) return 0;
    if ((data[5] & 0x01) != 0) slip_can_take_away(&s->last); /* rule 10: slipd stops */
    return SLIP_CAN_HEARD_HEARTBEAT;
  }
  return 0;
}

/* What may be used now, after all pending frames were read (rule 11). */
static inline struct slip_can_reading slip_can_now(const struct slip_can *s, double now_s) {
  struct slip_can_reading now = s->last;
  if (slip_can_silent(s, now_s)) slip_can_take_away(&now);
  return now;
}

#endif
