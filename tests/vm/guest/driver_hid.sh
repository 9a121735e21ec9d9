# slipd with its HID driver and a simulated device on /dev/uhid: the margin on the socket against the truth, a stall,
# unplugging, lost reports.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/margin.sh

cat >slipd.json <<'END'
{ "sensors": [ { "name": "pad", "driver": "hid", "profile": "vendor-hid-8x8", "device": { "serial": "HID42" }, "friction": 0.5,
                 "stale_after_ms": 1000 },
               { "name": "grip", "driver": "hid", "profile": "hid-force", "stale_after_ms": 1000 } ],
  "estimator": { "method": "moments" }, "realtime": { "mode": "off" }, "socket": { "path": "/tmp/slipd.sock" } }
END

modprobe uhid
in_background pad.log simulated-device vendor-hid --at uhid --serial HID42 --rate-hz 20 --script hold.json --truth truth.jsonl \
  --control /tmp/pad
awaits "the device's node" test -e /dev/hidraw0
# A force sensor of HID's Sensors page, found by its own descriptor.
in_background grip.log simulated-device hid-force --at uhid --serial HID43 --rate-hz 20 --script hold.json
awaits "the other's node" test -e /dev/hidraw1
in_background slipd.log slipd --config slipd.json
awaits "a margin" is pad state ok
awaits "the load that is held" near pad shear_n 0.9 0.01
awaits "the force that presses" near pad normal_n 3 0.05
awaits "the margin, as the truth has it" near pad gamma 0.4 0.03
echo "truth: $(tail -n 1 truth.jsonl)"
echo "measured: gamma $(of pad gamma), sigma $(of pad sigma), normal $(of pad normal_n) N, shear $(of pad shear_n) N"

awaits "a force sensor that tells no shear" is grip state no_shear
# 3 N on a square centimetre.
awaits "but how hard it is pressed" eval 'slipctl --socket /tmp/slipd.sock frame grip | tail -n 1 | grep -q "^0,0,30000,0,0"'

figures pad

order /tmp/pad stall 60
awaits "a sensor that stalls is stale" is pad state stale
awaits "and back by itself" is pad state ok

order /tmp/pad unplug
awaits "a sensor that is gone is a fault" is pad state fault
order /tmp/pad plug
awaits "and is opened again when it is back" is pad state ok
awaits "with the margin" near pad gamma 0.4 0.03

order /tmp/pad lose 5
awaits "what is lost is counted" eval 'echo "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"status\"}" | socat -t 5 - UNIX-CONNECT:/tmp/slipd.sock | grep -q "\"corrupt\":[1-9]"'
awaits "and the rest is as before" near pad gamma 0.4 0.03
kill "$background"
awaits "it ends on SIGTERM" eval '! kill -0 $background'
