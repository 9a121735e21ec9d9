# slipd's CAN output: messages on the bus agree with the socket, and no fault of the bus stops slipd or hides an estimate.
source /source/tests/vm/guest/check.sh

socket=/run/slipd-test.sock
counts=/run/counts  # what slipd's threads allocate: tests/support/allocation_guard.hpp
serve() {  # CAN-SECTION: starts slipd with it; $daemon is its process
  cat >config.json <<JSON
{ "sensors": [ { "name": "left", "driver": "sim", "rate_hz": 100, "stale_after_ms": 5000, "layout": { "grid": [8, 8], "pitch_mm": 1.8 } } ],
  "estimator": { "method": "moments" }, "realtime": { "mode": "off" }, "socket": { "path": "$socket" },
  "can": $1 }
JSON
  head -c 40 /dev/zero >$counts
  in_background slipd.log env LD_PRELOAD=/build/test-bin/libslipd-allocation-guard.so SLIPD_TEST_ALLOCATION_GUARD=$counts \
    slipd --config config.json
  daemon=$background
  awaits "slipd serves" slipctl --socket $socket gamma
}
ends() {
  kill "$daemon"
  wait "$daemon" || fail "it does not end well: $(cat slipd.log)"
}
status() { slipctl --socket $socket --json status; }
bus_is() { status | grep -q "\"can\":{[^}]*\"state\":\"$1\""; }
figure() { status | grep -o "\"can\":{[^}]*}" | grep -o "\"$1\":[0-9]*" | cut -d: -f2; }

# says_the_same WHAT LOG: compares the messages in LOG with the socket by the DBC of the running configuration. Ends slipd.
says_the_same() {
  in_background estimates.log slipctl --socket $socket --json watch --rate 1000
  local watcher=$background
  awaits "some hundred estimates: $1" eval 'test "$(grep -c "\"seq\"" estimates.log)" -ge 300'
  slipctl --socket $socket dbc >live.dbc
  kill "$watcher"
  ends
  can-check live.dbc "$2" estimates.log || fail "$1"
  echo "ok: $1"
}

modprobe vcan
ip link add vcan0 mtu 72 type vcan
ip link set vcan0 up

# Without allow_simulated, a simulated sensor sends the heartbeat only.
captures vcan0 withheld.log
serve '{ "interface": "vcan0" }'
awaits "two heartbeats" eval 'test "$(grep -c 5DF# withheld.log)" -ge 2'
same "and nothing else" "$(grep -vc 5DF# withheld.log)" 0
status | grep -q '"withheld":\["sensor left"\]' || fail "the status does not say so: $(status)"
ends
awaits "its last heartbeat" eval 'tail -n 1 withheld.log | grep -q "5DF#.\{10\}01"'

captures vcan0 vcan.log
serve '{ "interface": "vcan0", "allow_simulated": true }'
says_the_same "classic frames on the virtual bus are what the socket says" vcan.log
awaits "the last estimate is stale" eval 'grep 5A0# vcan.log | tail -n 1 | grep -q "5A0#FFFFFFFF[567]6"'

captures vcan0 fd.log
serve '{ "interface": "vcan0", "allow_simulated": true, "base_id": "0x12345600", "extended": true, "fd": true }'
says_the_same "FD frames with long identifiers, too" fd.log

can_up can0 can1
captures can1 wire.log
serve '{ "interface": "can0", "allow_simulated": true }'
says_the_same "and frames over a wire between two controllers" wire.log

# Faults of the bus. Each is shown in the status, and ends without a restart, with the newest value.
captures vcan0 faults.log
serve '{ "interface": "vcan0", "allow_simulated": true }'
frames() { grep -c 5A0# faults.log || true; }
sequence() { slipctl --socket $socket --json gamma | grep -o '"seq":[0-9]*' | head -n 1 | cut -d: -f2; }
# fault_begins: call it during the fault. sends_again WHAT: the first message after the fault is not older than the newest estimate then.
fault_begins() { newest=$(sequence) before=$(frames); }
sends_again() {
  awaits "$1" eval '(( $(frames) > before ))'
  local data
  data=$(grep 5A0# faults.log | sed -n "$((before + 1))p" | cut -d'#' -f2)
  (( (0x${data:13:1}${data:10:2} - newest + 4096 * 1000000) % 4096 < 2048 )) || fail "$1: $data is older than $newest"
}
metric() { slipctl --socket $socket metrics | grep "^slipd_can_$1"; }
before=0 newest=0
sends_again "messages"
printf '\1' | dd of=$counts conv=notrunc bs=1 status=none  # from here on allocations count
tc qdisc replace dev vcan0 root pfifo limit 0  # no room for any frame
awaits "a full queue is counted" eval 'test "$(figure queue_full)" -ge 20'
fault_begins
tc qdisc del dev vcan0 root
sends_again "messages once there is room"
cansend vcan0 20000004#0010000000000000
awaits "error-passive is reported" bus_is error_passive
cansend vcan0 20000040#0000000000000000
awaits "bus-off is reported" bus_is bus_off
cansend vcan0 20000100#0000000000000000
awaits "the controller's restart is reported" bus_is up
ip link set vcan0 down
awaits "an interface that is down is reported" bus_is down
captures_anew() {
  ip link set vcan0 up
  captures vcan0 faults.log  # candump ends with its interface
  before=0
}
fault_begins
captures_anew
awaits "it comes back" bus_is up
sends_again "and messages with it"
ip link del vcan0
awaits "an interface that is gone is reported" bus_is absent
ip link add vcan0 type vcan
fault_begins
captures_anew
awaits "a new one is found" bus_is up
sends_again "and used"
same "the metrics count the bus-off" "$(metric bus_offs_total)" "slipd_can_bus_offs_total 1"
metric queue_full_total | grep -q ' [1-9]' || fail "the metrics do not count the full queue: $(metric '')"
estimated=$(status | grep -o '"estimated":[0-9]*' | cut -d: -f2)
awaits "the pipeline goes on" eval "test \"\$(status | grep -o '\"estimated\":[0-9]*' | cut -d: -f2)\" -gt $estimated"
count() { od -An -tu8 -j "$1" -N 8 $counts | tr -d ' '; }
same "the thread of the bus has allocated nothing in all that" "$(count 24)" 0
test "$(count 32)" -gt 0 || fail "the guard counts nothing"
ends
cat slipd.log
