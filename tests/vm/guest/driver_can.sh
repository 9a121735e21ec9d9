# slipd with its CAN driver on a real controller: two simulated sensors of different make on one bus, the margin on the
# socket against the truth, a sensor that stalls and one that loses its power, and the interface going down and up.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/margin.sh

# The sensors of one bus share a device unless their profiles differ.
cat >slipd.json <<'END'
{ "sensors": [
    { "name": "pad", "driver": "can", "profile": "xela-xr1944", "device": { "interface": "can1" }, "friction": 0.5,
      "rate_hz": 20, "stale_after_ms": 1000 },
    { "name": "skin", "driver": "can", "profile": "icub-mtb", "device": { "interface": "can1", "for": "skin" },
      "rate_hz": 20, "stale_after_ms": 1000 } ],
  "estimator": { "method": "moments" }, "realtime": { "mode": "off" }, "socket": { "path": "/tmp/slipd.sock" } }
END
can_up can0 can1
in_background pad.log simulated-device xela-xr1944 --at can:can0 --rate-hz 20 --script hold.json --truth truth.jsonl --control /tmp/pad
in_background skin.log simulated-device icub-skin --at can:can0 --rate-hz 20 --script hold.json --control /tmp/skin
awaits "the sensors" eval 'grep -q ready pad.log && grep -q ready skin.log'
slipd --config slipd.json --check-config
in_background slipd.log slipd --config slipd.json
awaits "a margin" is pad state ok
awaits "the load that is held" near pad shear_n 0.9 0.01
awaits "the margin, as the truth has it" near pad gamma 0.4 0.03
echo "truth: $(tail -n 1 truth.jsonl)"
echo "measured: gamma $(of pad gamma), sigma $(of pad sigma), normal $(of pad normal_n) N, shear $(of pad shear_n) N"
awaits "the force that presses" near pad normal_n 3 0.05
same "a real sensor is not called simulated" "$(of pad simulated)" false
awaits "pressure alone tells no margin" is skin state no_shear

order /tmp/pad stall 60
awaits "a sensor that stalls is stale" is pad state stale
is skin state no_shear || fail "its neighbour on the bus is not"
awaits "and back by itself" is pad state ok

order /tmp/pad unplug
awaits "a sensor without power is stale" is pad state stale
order /tmp/pad plug
awaits "it is started again when it is back" is pad state ok

ip link set can1 down
awaits "an interface that is down is a fault" is pad state fault
ip link set can1 up
awaits "and is reopened when it is up" is pad state ok
awaits "with the margin" near pad gamma 0.4 0.03

order /tmp/pad lose 5
order /tmp/pad garbage 5
awaits "what is lost or garbled is counted" eval 'echo "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"status\"}" | socat -t 5 - UNIX-CONNECT:/tmp/slipd.sock | grep -q "\"corrupt\":[1-9]"'
awaits "and the rest is as before" near pad gamma 0.4 0.03
kill "$background"
awaits "it ends on SIGTERM" eval '! kill -0 $background'
