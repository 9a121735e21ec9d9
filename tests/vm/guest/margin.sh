# Shared by the tests of real drivers: a contact with a known margin, and slipd's answers on its socket, /tmp/slipd.sock. The
# sensor is free at first, for the two blocks of 16 frames of the bias. Then come one slip, from which friction is learnt, and a
# margin of 0.4, in cycles.
cat >hold.json <<'END'
{ "noise": 0, "cycle": [ { "ms": 3000, "normal_n": 0, "shear_n": 0, "friction": 0.5 }, { "ms": 300, "normal_n": [0, 3] },
                         { "ms": 600, "load": [0, 1.1] }, { "ms": 300, "shear_n": [1.5, 0.9] }, { "ms": 6000 } ] }
END
# of SENSOR MEMBER: a member of its estimate.
of() {
  echo '{"jsonrpc":"2.0","id":1,"method":"gamma"}' | socat -t 5 - UNIX-CONNECT:/tmp/slipd.sock | tr '{' '\n' |
    grep "\"sensor\":\"$1\"" | grep -o "\"$2\":[^,}]*" | cut -d: -f2 | tr -d '"'
}
is() { test "$(of "$1" "$2")" = "$3"; }
near() { awk -v got="$(of "$1" "$2")" -v want="$3" -v within="$4" 'BEGIN { exit !(got != "" && got - want < within && want - got < within) }'; }

# figures SENSOR: CPU time of slipd's acquire thread for each of its frames. It compares drivers within one guest only, since
# the guest's processor is emulated.
received() { slipctl --socket /tmp/slipd.sock --json status | tr '{' '\n' | grep "\"received\":" | head -n 1 | grep -o '"received":[0-9]*' | cut -d: -f2; }
figures() {
  local task frames cpu_ns
  task=$(grep -l "^acq:${1:0:11}" /proc/"$(pidof slipd)"/task/*/comm)
  frames=$(received)
  cpu_ns=$(cut -d' ' -f1 "${task%comm}schedstat")
  awaits "a hundred more frames" eval "(( \$(received) >= frames + 100 ))"
  echo "figures: $(( ($(cut -d' ' -f1 "${task%comm}schedstat") - cpu_ns) / 1000 / ($(received) - frames) )) us of CPU a frame of $1"
}
