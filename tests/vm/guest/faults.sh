# Faults that need a kernel of the test's own: the clock set back and forth, disks that are full or read-only (for recordings
# and for models), HID and USB devices unplugged REPLUGS times (a few by default, 200 in tools/faults). One boot for all.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/margin.sh
replugs=${REPLUGS:-2}
export STATE_DIRECTORY=/run/state
mkdir $STATE_DIRECTORY
mount -t tmpfs -o size=4m tmpfs $STATE_DIRECTORY  # more than the recordings of slips that are kept

figure() { slipctl --socket /tmp/slipd.sock metrics | sed -n "s/^slipd_$1{sensor=\"$2\"} //p"; }
more_frames() {  # WHAT: the simulated sensor goes on
  local before
  before=$(figure frames_estimated_total steady)
  awaits "$1" eval "(( \$(figure frames_estimated_total steady) > before + 5 ))"
}
recorder() { slipctl --socket /tmp/slipd.sock --json status | grep -o "\"recorder\":{[^}]*}" | grep -o "\"$1\":[0-9]*" | cut -d: -f2; }
recorder_is() { (( $(recorder "$1") >= $2 )); }
# One connection for repeated requests: starting a program for each of them would take most of the time.
connect() { coproc wire { exec socat - UNIX-CONNECT:/tmp/slipd.sock; }; }
is_connected() {  # SENSOR true|false
  echo '{"jsonrpc":"2.0","id":1,"method":"sensors"}' >&"${wire[1]}"
  read -r -t 20 -u "${wire[0]}" answer
  [[ $answer =~ \"name\":\"$1\",[^}]*\"connected\":$2, ]]
}
descriptors() { find "/proc/$slipd/fd" -mindepth 1 | wc -l; }

cat >slipd.json <<'END'
{ "sensors": [ { "name": "pad", "driver": "hid", "profile": "vendor-hid-8x8", "device": { "serial": "HID42" }, "stale_after_ms": 5000 },
               { "name": "hub", "driver": "usb", "profile": "contactile-pts2", "device": { "serial": "USB42" }, "rate_hz": 20,
                 "stale_after_ms": 5000 },
               { "name": "steady", "driver": "sim", "rate_hz": 50, "stale_after_ms": 2000, "layout": { "grid": [8, 8], "pitch_mm": 1.8 } } ],
  "recorder": { "seconds": 0.2, "keep": 3 },
  "estimator": { "method": "moments" }, "realtime": { "mode": "off" }, "socket": { "path": "/tmp/slipd.sock" } }
END
modprobe -a uhid vhci-hcd
in_background pad.log simulated-device vendor-hid --at uhid --serial HID42 --rate-hz 50 --script hold.json --control /tmp/pad
in_background hub.log simulated-device papillarray --at usbip:3240 --serial USB42 --rate-hz 20 --script hold.json --control /tmp/hub
awaits "the devices" eval 'test -e /dev/hidraw0 && grep -q ready hub.log'
usbip attach -r 127.0.0.1 -b 1-1
in_background slipd.log slipd --config slipd.json
slipd=$background
for sensor in pad hub steady; do awaits "frames of $sensor" eval "(( \$(figure frames_estimated_total $sensor) > 0 ))"; done

# Unplugged and plugged in again.
connect
awaits "both connected" eval 'is_connected pad true && is_connected hub true'
open=$(descriptors)
began=$SECONDS
trap 'tail -n 3 replugs.log' EXIT
for ((i = 1; i <= replugs; ++i)); do
  order /tmp/pad unplug
  order /tmp/hub unplug
  awaits "both gone" eval 'is_connected pad false && is_connected hub false'
  order /tmp/pad plug
  order /tmp/hub plug
  awaits "served again" usbip attach -r 127.0.0.1 -b 1-1
  awaits "back, for the ${i}th time" eval 'is_connected pad true && is_connected hub true'
done >replugs.log
trap - EXIT
(( $(figure reconnects_total pad) >= replugs && $(figure reconnects_total hub) >= replugs )) || fail "not all are counted"
for sensor in pad hub; do
  before=$(figure frames_received_total $sensor)
  awaits "frames of $sensor after $replugs replugs" eval "(( \$(figure frames_received_total $sensor) > before ))"
done
awaits "no descriptor more than the $open before" eval "(( \$(descriptors) <= open ))"
echo "figures: HID and USB replugged $replugs times each in $((SECONDS - began)) s"

# The clock, back and forth. No estimate may become stale by it, and each has the new time.
right=$(date +%s)
in_background states.log slipctl --socket /tmp/slipd.sock --json watch steady
for days in -1 +400 -4000 +3 0; do
  date -s "@$((right + days * 86400))" >/dev/null
  more_frames "frames go on with the clock $days days off"
  reported=$(of steady time_ns)
  (( reported / 1000000000 - right - days * 86400 < 300 )) || fail "the time reported is not the clock's"
  (( right + days * 86400 - reported / 1000000000 < 300 )) || fail "the time reported is not the clock's"
done
kill "$background" || echo "note: the watcher gave up before: this machine is very slow"
refused "no estimate was stale meanwhile" grep -q '"state":"\(stale\|fault\)"' states.log
# A recording that is written while the clock is a day behind is not the first to be removed.
date -s "@$((right - 86400))" >/dev/null
slipctl --socket /tmp/slipd.sock flight steady >/dev/null
awaits "a recording with the clock a day back" recorder_is kept 1
date -s "@$right" >/dev/null

# A stop with a driver that hangs, while the clock goes back by an hour: it still ends in time.
cat >hang.json <<'END'
{ "sensors": [ { "name": "ill", "driver": "trial", "options": { "behaviour": "hang_in_read" } } ],
  "estimator": { "method": "moments" }, "realtime": { "mode": "off" }, "socket": { "path": "/tmp/hang.sock" } }
END
in_background hang.log /build/bin/slipd --config hang.json --driver-dir /build/test-drivers
hanging=$background
awaits "the other slipd" slipctl --socket /tmp/hang.sock gamma
kill "$hanging"
date -s "@$((right - 3600))" >/dev/null
awaits "it ends in time although the clock went back" eval '! kill -0 $hanging'
date -s "@$((right + 60))" >/dev/null

# A disk that is full, one that is read-only.
head -c 8M /dev/zero >$STATE_DIRECTORY/filler 2>/dev/null || true
refused "a flight recording onto a full disk fails" slipctl --socket /tmp/slipd.sock flight steady 2>flight.log
grep -q "No space left on device" flight.log || fail "slipctl does not say why: $(cat flight.log)"
awaits "it is counted" recorder_is failed 1
awaits "and the log says why" grep -q "No space left on device" slipd.log
more_frames "and nothing else"
refused "a recording onto it ends with its reason" slipctl --socket /tmp/slipd.sock record --sensor steady --seconds 1 --out $STATE_DIRECTORY/r.rec 2>record.log
grep -q "No space left on device" record.log || fail "slipctl does not say why: $(cat record.log)"
mount -o remount,ro $STATE_DIRECTORY
refused "onto a read-only one, too" slipctl --socket /tmp/slipd.sock flight steady
awaits "a read-only disk does, too, and the log says why" grep -q "Read-only file system" slipd.log
more_frames "and nothing else"
mount -o remount,rw $STATE_DIRECTORY
rm $STATE_DIRECTORY/filler
kept=$(recorder kept)
# A recording of a slip may be under way just now, and the disk is small.
awaits "a flight recording has room again" slipctl --socket /tmp/slipd.sock flight steady
awaits "with room again, recordings are kept" recorder_is kept $((kept + 1))
no_leftovers() { [[ -z $(find $STATE_DIRECTORY -name '*.part' -o -name '*.new-*') ]]; }
awaits "what is there is whole, without leftovers" no_leftovers

kill "$slipd"
awaits "it ends on SIGTERM" eval '! kill -0 $slipd'

# A model on a disk that is full, then read-only, then has room again: it is used each time, and kept the last time.
mkdir /run/models
mount -t tmpfs -o size=4m tmpfs /run/models
cat >model.json <<'END'
{ "sensors": [ { "name": "pad", "driver": "sim", "rate_hz": 50, "stale_after_ms": 5000, "layout": { "grid": [8, 8], "pitch_mm": 1.8 } } ],
  "estimator": { "method": "svd-knn" }, "realtime": { "mode": "off" }, "socket": { "path": "/tmp/slipd.sock" } }
END
model_is_made() {  # LOG WHAT
  STATE_DIRECTORY=/run/models in_background "$1" slipd --config model.json
  slipd=$background
  awaits "$2: the sensor has its estimator" eval '(( $(figure frames_estimated_total pad) > 0 ))'
  kill "$slipd"
  awaits "it ends" eval '! kill -0 $slipd'
}
head -c 4M /dev/zero >/run/models/filler 2>/dev/null || true
model_is_made full.log "no room for a model"
grep -q "is used, but not kept.*No space left on device" full.log || fail "the log does not say why: $(cat full.log)"
mount -o remount,ro /run/models
model_is_made readonly.log "a read-only disk for a model"
grep -q "is used, but not kept.*Read-only file system" readonly.log || fail "the log does not say why: $(cat readonly.log)"
mount -o remount,rw /run/models
rm /run/models/filler
same "neither left anything" "$(find /run/models -type f)" ""
model_is_made room.log "room for a model"
same "it is kept, once and whole" "$(find /run/models -type f | grep -c .)" 1
model_is_made again.log "a model on disk"
refused "which is not made anew" grep -q "made anew\|training" again.log
