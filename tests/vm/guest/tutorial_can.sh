# docs/tutorials/can-pad.md with nothing but the packages: a pad of 4 x 4 on a real CAN controller of the kernel's, from the installation to
# calibrated newtons and an alert on the bus. Commands, configuration and what is printed are the page's. The pad reads twice what rests on it,
# so that there is something to find.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/service.sh
page=/source/docs/tutorials/can-pad.md
sudo() { "$@"; }  # the script is root's

block() { awk -v kind="$1" -v wanted="$2" '/^```/{if (inside) inside = 0; else if ($0 == "```" kind) inside = ++seen; next} inside == wanted' "$page"; }

# shows N COMMAND…: prints each line of the page's Nth text block; … in it stands for anything.
shows() {
  local expected=$1 got line
  shift
  got=$("$@" 2>&1) || true
  while read -r line; do
    line=$(sed 's/[][\.*^$(){}+?|]/\\&/g; s/…/.*/g; s/  */ +/g' <<<"$line")
    grep -Eq "^ *$line *$" <<<"$got" || { echo "expected: $line"; echo "$got"; return 1; }
  done < <(block text "$expected" | grep .)
}

begun=$SECONDS
modprobe kvaser_pci
ip link set can1 type can bitrate 1000000 restart-ms 100
ip link set can1 up txqueuelen 256
eval "$(block sh 1 | grep '^sudo ip')"
ip -details link show can0 | grep -q ERROR-ACTIVE || fail "the bus is not up as the page says"
echo "0 0 0 0 0" >load
in_background device.log /build/test-bin/simulated-device xela-xr1944 --at can:can1 --rate-hz 20 --weights load
awaits "the pad" grep -q ready device.log
refused "the pad waits for its start command" timeout 1 candump -n 1 can0

installs slipd slipd-driver-can slipd-realtime
people
awaits "slipctl status answers" as alice slipctl status

# A guest without KVM sends 20 frames a second: that shall not count as a sensor that is gone.
block jsonc 1 | sed 's/"name": "pad",/& "stale_after_ms": 5000,/' >"$config"
eval "$(block sh 2 | grep -v 'slipctl sensors')"
awaits "frames" estimates
shows 1 as alice slipctl sensors || fail "slipctl sensors shows something else than the page"

eval "$(block sh 3 | grep rebias)" | grep -q 'pad: zeroed' || fail "no zero"
awaits "a zero" eval 'as alice slipctl gamma pad | grep -q no_contact'

# Calibration asks for one weight after the other: who is told lays it there. 200 g are 1.961 N, 100 g 0.981 N, and the pad reads twice.
received() { as alice slipctl --json status | grep -o '"received":[0-9]*' | head -n 1 | cut -d: -f2; }
calibrates() {
  local before step loads=("0 0 0 0 0" "0 0 $1 0 0" "$2 0 1 0 0" "0 $2 1 0 0" "0 0 $1 -7.05 -7.05" "0 0 $1 7.05 -7.05")
  rm -f /run/keys
  mkfifo -m 666 /run/keys
  # shellcheck disable=SC2046 # the page's words
  as alice $(block sh 4) </run/keys >factors 2>asked &
  exec 9>/run/keys
  for step in "${!loads[@]}"; do
    awaits "calibration asks for step $((step + 1))" eval "[[ \$(grep -o 'Then press Enter' asked | wc -l) -gt $step ]]"
    echo "${loads[step]}" >load.new
    mv load.new load
    before=$(received)
    awaits "the weight lies there" eval '(($(received) > before + 2))'
    echo >&9
  done
  wait $! || { cat asked factors; fail "slipctl calibrate"; }
  exec 9>&-
  echo "0 0 0 0 0" >load
}
chmod a+rx . && touch asked factors
calibrates 3.9227 1.9613
shows 2 cat factors || fail "the page shows other factors"
gain=$(grep -o '"gain": [0-9.]*' factors)
sed -i "s/\"name\": \"pad\",/& $gain,/" "$config"
systemctl reload slipd
awaits "frames after the reload" estimates
calibrates 3.9227 1.9613
grep -Eq 'normal +factor (1|1\.0.*|0\.99.*) ' factors || { cat factors; fail "calibrated, it is no newton"; }
echo "ok: $((SECONDS - begun)) s from the packages to a calibrated pad, in a guest without KVM"

# What the gripper's controller hears: the base of the page's configuration.
kill "$background"
echo '{"noise":0,"cycle":[{"ms":1500,"normal_n":0,"shear_n":0,"friction":0.6},{"ms":500,"normal_n":[0,6]},{"ms":1000},{"ms":4000,"load":[0,1.1]},{"ms":1000},{"ms":300,"load":[1.1,0]},{"ms":300,"normal_n":[6,0]}]}' >pulls.json
in_background device.log /build/test-bin/simulated-device xela-xr1944 --at can:can1 --rate-hz 20 --script pulls.json
awaits "an alert" eval 'as alice slipctl gamma pad | grep -Eq "\b(warn|slip)\b"'
awaits "SLIP_ALERT on the bus" eval 'timeout 5 candump -n 1 can0,5C0:7FF'
