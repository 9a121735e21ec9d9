// Shared by the parts of daemon-bench: how long they measure and how they print.
#pragma once

#include <chrono>
#include <nlohmann/json.hpp>

#include "tests/bench/times.hpp"

namespace slipd::bench {

using nlohmann::json;

extern bool brief;  // each part for a moment only, as a test of the program

std::chrono::milliseconds length(std::chrono::milliseconds whole);  // a twentieth of it if brief
void say(const char* part, json values);                            // one line of JSON
json to_json(const Quantiles& of);

// `gamma` against a server that only echoes, and against GET of a value of the answer's size, by the same
// clients, in turn; then `gamma` beside subscribers.
void queries();

// The board in shared memory: the cost of reading it and of waiting for it.
void shared();

// Frames from a program beside those of a device in the daemon: latency and CPU time.
void push();

// One sensor to 128, as so many devices and on one bus: CPU time by thread, sample to shared memory, frames
// skipped, memory; and what the devices and the estimates cost alone. The second measures only those that
// have goals.
void growth();
void growth_goals();

// From the sample to the shared memory, with and without real-time scheduling, alone and beside stress-ng.
void stressed();

// From the start of redis-server to its first answer.
void redis_startup();

}  // namespace slipd::bench
