# In a guest whose time is that of its own processor, independent of the host, SLIP_ESTIMATE comes in every period, within a
# tenth of it.
source /source/tests/vm/guest/check.sh

modprobe vcan
ip link add vcan0 type vcan
ip link set vcan0 up
captures vcan0 frames.log
cat >config.json <<JSON
{ "sensors": [ { "name": "left", "driver": "sim", "rate_hz": 100, "layout": { "grid": [8, 8], "pitch_mm": 1.8 } } ],
  "estimator": { "method": "moments" }, "socket": { "path": "/tmp/slipd.sock" },
  "can": { "interface": "vcan0", "allow_simulated": true } }
JSON
in_background slipd.log slipd --config config.json
daemon=$background
awaits "slipd is ready" grep -q serves slipd.log
from=$(grep -c 5A0# frames.log || true)
awaits "three hundred frames" eval '(( $(grep -c 5A0# frames.log) >= from + 310 ))'
kill "$daemon"
wait "$daemon" || fail "it does not end well: $(cat slipd.log)"
cat slipd.log

# candump prints the kernel's times, at which each message was sent.
grep 5A0# frames.log | head -n -1 | tr -d '()' | awk -v from="$from" '
  NR > from + 1 { gap = 1000 * ($1 - last); if (least == "" || gap < least) least = gap; if (gap > most) most = gap
                  if (gap < 9 || gap > 11) { print "gap of " gap " ms before " $0; ++off } ++gaps }
  { last = $1 }
  END { print gaps " periods of 10 ms: " least " to " most " ms"; exit gaps < 300 || off > 0 }' || fail "frames keep no period"
