# An administrator's day with the packages: what is refused names its cause and its remedy, a first HID device is plugged in after
# the start, several packages are one restart, a removal leaves nothing that failed, and the pages are there.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/service.sh
restarts() { journalctl -q -o cat -u slipd.service | grep -c 'slipd .* serves'; }
trouble() { as alice slipctl --json status | grep -o "\"trouble\":\"[^\"]*\""; }
sensor() { echo "{ \"sensors\": [ { \"name\": \"left\", $1, \"stale_after_ms\": 5000 } ], \"estimator\": { \"method\": \"moments\" } ${2:-} }" >$config; }

installs slipd
people
dpkg -L slipd | grep -qx /usr/share/doc/slipd/service.md || fail "there are no pages"
echo "ok: the pages are there"

# CAN: not permitted, no such interface, no CAN interface.
can_up can0
sensor '"driver": "sim", "rate_hz": 50, "layout": { "grid": [8, 8], "pitch_mm": 1.8 }' ', "can": { "interface": "can0" }'
systemctl reload slipd || fail "a good configuration is refused: $(why)"
awaits "CAN without its package names the package" eval 'trouble | grep -q "slipd-driver-can"'
refused "and does not say that the kernel has none" eval 'trouble | grep -q "no CAN"'
sensor '"driver": "can", "profile": "xela-xr1944", "device": { "interface": "lo" }'
refused "without its package there is no such driver" systemctl reload slipd
why | grep -q 'install the package slipd-driver-can' || fail "the package is not named: $(why)"

# Four packages at once: one restart, when all are there.
sensor '"driver": "sim", "rate_hz": 50, "layout": { "grid": [8, 8], "pitch_mm": 1.8 }'
systemctl reload slipd
in_background watched as alice slipctl --json watch --rate 5
awaits "a client follows" grep -q '"sensor":"left"' watched
before=$(restarts)
installs slipd slipd-driver-can slipd-driver-hid slipd-driver-modbus
same "four packages are one restart" "$(($(restarts) - before))" 1
same "and it runs" "$(systemctl is-active slipd)" active
awaits "the client comes back" grep -q 'slipd is back' watched
kill "$background"

sensor '"driver": "can", "profile": "xela-xr1944", "device": { "interface": "lo" }'
systemctl reload slipd || fail "a good configuration is refused: $(why)"
awaits "an interface that is none of CAN is called that" eval 'trouble | grep -q "no CAN interface"'
sensor '"driver": "can", "profile": "xela-xr1944", "device": { "interface": "can0" }'
systemctl reload slipd || fail "a reload is refused: $(why)"
awaits "a silent bus is no sensor that works" eval 'as alice slipctl sensors | grep -q "open, no frames"'

# Modbus: the unit denies the address.
sensor '"driver": "modbus", "profile": "onrobot-rg2-ft", "device": { "host": "127.0.0.1" }'
systemctl reload slipd || fail "a reload is refused: $(why)"
awaits "a denied address names the setting" eval 'trouble | grep -q "IPAddressAllow=127.0.0.1"'

# HID: the module was not loaded by any device before the service started.
sensor '"driver": "hid", "profile": "vendor-hid-8x8"'
systemctl restart slipd || fail "it does not start: $(why)"
awaits "without a device there is a fault" eval 'trouble | grep -q "is not there"'
modprobe uhid
in_background pad.log /build/test-bin/simulated-device vendor-hid --at uhid --serial HID42 --rate-hz 20
awaits "a first device that comes later is read" eval 'as alice slipctl --json status | grep -q "\"received\":[1-9]"'

# A profile of reports of another length.
mkdir -p /etc/slipd/profiles
sed 's/"length": 64/"length": 65/' /usr/share/slipd/profiles/vendor-hid-8x8.json >/etc/slipd/profiles/short.json
sensor '"driver": "hid", "profile": "short"'
systemctl reload slipd || fail "the profile is refused: $(why)"
awaits "reports of another length are told" eval 'trouble | grep -q "reports of 64 bytes arrive, the profile expects 65"'
awaits "and counted" eval 'as alice slipctl --json status | grep -q "\"corrupt\":[1-9]"'

# The driver that the configuration needs is removed: what runs goes on, and nothing has failed.
by_apt remove slipd-driver-hid 2>&1 | tee removal.log
grep -q 'install the package slipd-driver-hid' removal.log || fail "the reason is not told"
refused "no job fails" grep -q 'Job for slipd' removal.log
same "it goes on" "$(systemctl is-active slipd)" active
by_apt remove slipd-driver-can slipd-driver-modbus slipd 2>&1 | tee removal.log
refused "no job fails when all are removed" grep -q 'Job for slipd' removal.log
same "no unit has failed" "$(systemctl list-units --failed --plain --no-legend 'slipd*')" ""
