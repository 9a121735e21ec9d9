# Faults of the sensor, the pipeline or slipd itself: a listener that follows docs/can.md learns of each with the next message,
# or with the first that is missing, and never takes an old margin for a new one.
source /source/tests/vm/guest/check.sh

modprobe vcan
ip link add vcan0 type vcan
ip link set vcan0 up

serve() {  # OPTIONS: slipd with a trial sensor, for which it passes as a real one; $daemon is its process
  cat >config.json <<JSON
{ "sensors": [ { "name": "left", "driver": "trial", "rate_hz": 50, "stale_after_ms": 500, "layout": { "grid": [16, 16], "pitch_mm": 0.9 },
                 "options": { "simulated": false, "after": 150, "gamma": 0.7$1 } } ],
  "estimator": { "method": "moments" }, "realtime": { "mode": "off" }, "socket": { "path": "/tmp/slipd.sock" },
  "can": { "interface": "vcan0", "period_ms": $period } }
JSON
  [[ ! ${capture-} ]] || kill "$capture" || true
  captures vcan0 frames.log
  capture=$background
  mark
  in_background slipd.log slipd --config config.json --driver-dir /build/test-drivers
  daemon=$background
}
ends() {
  kill "$daemon"
  wait "$daemon" || fail "it does not end well: $(cat slipd.log)"
  # SLIP_ESTIMATE_0: Gamma in the first two bytes, State in the low half of the fifth.
  refused "no frame has a margin but in state ok" eval 'grep -E "5A0#.{9}[^0]" frames.log | grep -v "5A0#FFFF"'
}
# A period that slipd can keep on an emulated processor.
period=50
in_background c.log slip-listen vcan0 5A0 $period
in_background python.log python3 /build/test-bin/slip-listen.py vcan0 5A0 $period

state() { tail -n 1 frames.log | grep -qE "5A0#.{9}$1"; }
mark() { c=$(wc -l <c.log) python=$(wc -l <python.log); }
since() { tail -n +$((c + 1)) c.log | grep -q "$1" && tail -n +$((python + 1)) python.log | grep -q "$1"; }
believe() { tail -n 1 c.log | grep -q "$1" && tail -n 1 python.log | grep -q "$1"; }
# Both listeners report no margin, and report nothing else while the fault lasts.
doubt() {
  awaits "$1: the listeners know" believe "no margin"
  mark
  awaits "$1: and go on knowing" eval '(( $(wc -l <c.log) > c + 5 && $(wc -l <python.log) > python + 5 ))'
  refused "$1: an old margin is never taken for a new one" eval \
    'tail -n +$((c + 1)) c.log | grep "^margin" || tail -n +$((python + 1)) python.log | grep "^margin"'
}
trust() { awaits "$1" since 'margin 0.7'; }
awaits "Python's listener is up" grep -q "no margin" python.log

serve ', "behaviour": "hang_in_read"'
trust "a margin"
awaits "a driver that hangs is stale" state 6
doubt "a driver that hangs"
kill "$daemon"
wait "$daemon" || true

serve ', "behaviour": "nonsense"'
trust "a margin"
awaits "frames that fit no contact have state out_of_model" state 3
doubt "frames that fit no contact"
ends

serve ', "behaviour": "vanish"'
trust "a margin"
awaits "a sensor that is gone is a fault" grep -qE "5A0#.{9}7" frames.log
awaits "of which the listeners know" since "no margin"
mark
trust "and when it is back there is a margin"
ends

serve ''
trust "a margin"
in_background stop.log stop-thread "$daemon" estimate
holder=$background
awaits "the estimate thread stands still" grep -q stopped stop.log
awaits "what nobody renews is stale" state 6
doubt "a pipeline that stands still"
kill "$holder"
trust "it goes on, and there is a margin"

kill -STOP "$daemon"
doubt "a process that stands still"
kill -CONT "$daemon"
trust "it goes on, and there is a margin"

ip link set vcan0 down
doubt "a bus that is down"
ip link set vcan0 up
captures vcan0 frames.log  # candump ended with its interface
capture=$background
trust "it is up, and there is a margin"

ends
awaits "its last estimate is stale" eval 'grep 5A0# frames.log | tail -n 1 | grep -qE "5A0#FFFF.{5}6"'
awaits "its last heartbeat says that it stops" eval 'grep 5DF# frames.log | tail -n 1 | grep -qE "5DF#.{10}01"'
doubt "a slipd that stops"

serve ''
trust "a margin"
kill -KILL "$daemon"
doubt "a slipd that is killed"
