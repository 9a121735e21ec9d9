# slipd with its USB driver and a simulated hub served over USB/IP, a serial port to the kernel: the margin of both of its
# sensors on the socket against the truth, a stall, unplugging, packets lost and damaged.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/margin.sh

cat >slipd.json <<'END'
{ "sensors": [ { "name": "left", "driver": "usb", "profile": "contactile-pts2", "device": { "serial": "USB42" }, "friction": 0.5,
                 "rate_hz": 20, "stale_after_ms": 1000 },
               { "name": "right", "driver": "usb", "profile": "contactile-pts2", "device": { "serial": "USB42" }, "friction": 0.5,
                 "rate_hz": 20, "stale_after_ms": 1000, "options": { "sensor": 1 } } ],
  "estimator": { "method": "moments" }, "realtime": { "mode": "off" }, "socket": { "path": "/tmp/slipd.sock" } }
END

modprobe vhci-hcd
in_background hub.log simulated-device papillarray --at usbip:3240 --serial USB42 --rate-hz 20 --script hold.json \
  --truth truth.jsonl --control /tmp/hub
awaits "the hub is served" grep -q ready hub.log
usbip attach -r 127.0.0.1 -b 1-1
awaits "the kernel has it as a serial port" test -e /dev/ttyACM0
slipd --config slipd.json --check-config
in_background slipd.log slipd --config slipd.json
for sensor in left right; do
  awaits "a margin of $sensor" is $sensor state ok
  awaits "the load that is held" near $sensor shear_n 0.9 0.01
  awaits "the force that presses" near $sensor normal_n 3 0.05
  awaits "the margin, as the truth has it" near $sensor gamma 0.4 0.03
done
echo "truth: $(tail -n 1 truth.jsonl)"
echo "measured: gamma $(of left gamma), sigma $(of left sigma), normal $(of left normal_n) N, shear $(of left shear_n) N"
refused "its interface is taken from the kernel's driver" test -e /dev/ttyACM0

figures left

order /tmp/hub stall 60
awaits "a sensor that stalls is stale" is left state stale
awaits "and back by itself" is left state ok

order /tmp/hub unplug
awaits "a sensor that is gone is a fault" is left state fault
order /tmp/hub plug
awaits "it is served again" usbip attach -r 127.0.0.1 -b 1-1
awaits "and is opened again when it is back" is left state ok
awaits "with the margin" near left gamma 0.4 0.03

for what in lose garbage shorten lengthen repeat; do order /tmp/hub $what 3; done
awaits "what is lost is counted" eval 'echo "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"status\"}" | socat -t 5 - UNIX-CONNECT:/tmp/slipd.sock | grep -q "\"corrupt\":[1-9]"'
awaits "and the rest is as before" near left gamma 0.4 0.03
kill "$background"
awaits "it ends on SIGTERM" eval '! kill -0 $background'
awaits "the kernel has its serial port again" test -e /dev/ttyACM0
