# A sensor on USB and one on HID, read by the packaged drivers within the limits of their drop-ins and udev rules; both
# unplugged and plugged in again, of which libusb is notified over netlink.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/service.sh
modprobe vhci-hcd
modprobe uhid
in_background hub.log /build/test-bin/simulated-device papillarray --at usbip:3240 --serial USB42 --rate-hz 20 --control /tmp/hub
in_background pad.log /build/test-bin/simulated-device vendor-hid --at uhid --serial HID42 --rate-hz 20
in_background keys.log /build/test-bin/simulated-device hid-force --at uhid --serial HID43 --rate-hz 20
awaits "the hub is served" grep -q ready hub.log
usbip attach -r 127.0.0.1 -b 1-1
awaits "the HID devices are there" test -e /dev/hidraw1
hid_groups() { stat -c %G /dev/hidraw* | sort | xargs; }

installs slipd
people
cat >$config <<'JSON'
{ "sensors": [ { "name": "left", "driver": "usb", "profile": "contactile-pts2", "device": { "serial": "USB42" }, "stale_after_ms": 5000 },
               { "name": "pad", "driver": "hid", "profile": "vendor-hid-8x8", "device": { "serial": "HID42" }, "stale_after_ms": 5000 } ],
  "estimator": { "method": "moments" } }
JSON
refused "without their packages there are no such drivers" systemctl reload slipd
why | grep -q 'slipd-driver-usb' || fail "the log does not say what to install: $(why)"
installs slipd-driver-usb slipd-driver-hid
# Both were plugged in before the rules were installed.
awaits "the USB device is slipd's group's" eval 'stat -c %G /dev/bus/usb/*/* | grep -q "^slipd$"'
awaits "of the HID devices the one with a profile is" eval '[[ $(hid_groups) == "root slipd" ]]'
systemctl restart slipd || fail "with their packages it does not start: $(why)"
received() { as alice slipctl --json status | grep -o '"received":[0-9]*' | grep -vc ':0$' | grep -qx 2; }
awaits "frames of both are received" received
order /tmp/hub unplug
awaits "without it there is a fault" eval 'as alice slipctl --json sensors | grep -q "\"name\":\"left\".*\"connected\":false.*\"name\":\"pad\""'
order /tmp/hub plug
awaits "it is served again" usbip attach -r 127.0.0.1 -b 1-1
awaits "and read again" eval '[[ $(as alice slipctl --json sensors | grep -o "\"connected\":true" | wc -l) == 2 ]]'
same "the journal knows whose fault it was" \
  "$(journalctl -q -o cat --output-fields=MESSAGE SLIPD_SENSOR=left SLIPD_CAUSE=device | grep -c 'the device is gone')" 1
as alice slipctl sensors
same "no other USB device is slipd's" "$(stat -c %G /dev/bus/usb/*/* | sort | uniq -c | awk '$2 == "slipd" { print $1 }')" 1
dpkg -P slipd-driver-usb slipd-driver-hid
refused "purged, the drivers are gone" eval 'ls /usr/lib/*/slipd/ | grep "usb\|hid"'
same "and so are their drop-ins" "$(property DropInPaths)" ""
