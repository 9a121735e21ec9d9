# A sensor on a CAN bus, read by the packaged driver within the limits of its drop-in for the hardened service.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/service.sh
can_up can0 can1
in_background device.log /build/test-bin/simulated-device xela-xr1944 --at can:can0 --rate-hz 20 --truth truth.jsonl
awaits "the sensor" grep -q ready device.log

installs slipd
people
cat >/run/can.json <<'JSON'
{ "sensors": [ { "name": "left", "driver": "can", "profile": "xela-xr1944", "device": { "interface": "can1" }, "stale_after_ms": 5000 } ],
  "estimator": { "method": "moments" } }
JSON
cp /run/can.json $config
refused "without its package there is no such driver" systemctl reload slipd
installs slipd-driver-can
systemctl reload slipd || systemctl restart slipd || fail "with its package it does not start: $(why)"
awaits "frames from the bus are estimated" estimates
why | grep -i 'warning\|error' || true
as alice slipctl sensors
dpkg -P slipd-driver-can
refused "purged, the driver is gone" test -e "$(echo /usr/lib/*/slipd)/slipd-driver-can.so"
same "and so is its drop-in" "$(property DropInPaths)" ""
