# slipd with its CAN driver on a real controller: two simulated sensors of different make on one bus, the margin on the
# socket against the truth, a sensor that stalls and one that loses its power, and the interface going down and up.
source /source/tests/vm/guest/check.sh

# It slips once, so that friction can be learnt, and is then held at a margin of 0.4, again and again.
cat >hold.json <<'END'
{ "noise": 0, "cycle": [ { "ms": 300, "normal_n": 0, "shear_n": 0, "friction": 0.5 }, { "ms": 300, "normal_n": [0, 3] },
                         { "ms": 600, "load": [0, 1.1] }, { "ms": 300, "shear_n": [1.5, 0.9] }, { "ms": 6000 } ] }
END
# The sensors of one bus share a device unless their profiles differ.
cat >slipd.json <<'END'
{ "sensors": [
    { "name": "pad", "driver": "can", "profile": "xela-xr1944", "device": { "interface": "can1" }, "friction": 0.5,
      "rate_hz": 20, "stale_after_ms": 1000 },
    { "name": "skin", "driver": "can", "profile": "icub-mtb", "device": { "interface": "can1", "for": "skin" },
      "rate_hz": 20, "stale_after_ms": 1000 } ],
  "estimator": { "method": "moments" }, "realtime": { "mode": "off" }, "socket": { "path": "/share/slipd.sock" } }
END
# of SENSOR EXPRESSION: a member of its estimate.
of() {
  echo '{"jsonrpc":"2.0","id":1,"method":"gamma"}' | socat -t 5 - UNIX-CONNECT:/tmp/slipd.sock | tr '{' '\n' |
    grep "\"sensor\":\"$1\"" | grep -o "\"$2\":[^,}]*" | cut -d: -f2 | tr -d '"'
}
is() { test "$(of "$1" "$2")" = "$3"; }
near() { awk -v got="$(of "$1" "$2")" -v want="$3" -v within="$4" 'BEGIN { exit !(got != "" && got - want < within && want - got < within) }'; }

can_up can0 can1
sed -i 's|/share/slipd.sock|/tmp/slipd.sock|' slipd.json
in_background pad.log simulated-device xela-xr1944 --at can:can0 --rate-hz 20 --script hold.json --truth truth.jsonl --control /tmp/pad
in_background skin.log simulated-device icub-skin --at can:can0 --rate-hz 20 --script hold.json --control /tmp/skin
awaits "the sensors" eval 'grep -q ready pad.log && grep -q ready skin.log'
slipd --config slipd.json --check-config
in_background slipd.log slipd --config slipd.json
awaits "a margin" is pad state ok
awaits "the load that is held" near pad shear_n 0.9 0.01
awaits "the margin, as the truth has it" near pad gamma 0.4 0.03
echo "truth: $(tail -n 1 truth.jsonl)"
echo "told: gamma $(of pad gamma), sigma $(of pad sigma), normal $(of pad normal_n) N, shear $(of pad shear_n) N"
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
awaits "it ends when told to" eval '! kill -0 $background'
