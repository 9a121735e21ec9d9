# A USB sensor read by the hardened service with the drop-in and the udev rules of its package, and no further rights: found,
# detached from the kernel's driver, unplugged, and found again, of which libusb is notified over netlink. The programs are
# those of the build tree; the tests of packages use packaged ones.
source /source/tests/vm/guest/check.sh
modprobe vhci-hcd
systemd-sysusers /source/systemd/sysusers/slipd.conf
mkdir -p /run/udev/rules.d
cp /source/systemd/udev/60-slipd-usb.rules /run/udev/rules.d/
udevadm control --reload
cat >/run/slipd.json <<'END'
{ "sensors": [ { "name": "left", "driver": "usb", "profile": "contactile-pts2", "device": { "serial": "USB42" },
                 "stale_after_ms": 5000 } ],
  "estimator": { "method": "moments" } }
END
mkdir -p /run/systemd/system/slipd.service.d
sed 's|^ExecStart=.*|ExecStart=/build/bin/slipd --config /run/slipd.json|; /^ExecReload=/d' /build/systemd/slipd.service \
  >/run/systemd/system/slipd.service
systemctl daemon-reload
why() { journalctl --no-pager -o cat -u slipd.service | tail -n 20; }

in_background hub.log simulated-device papillarray --at usbip:3240 --serial USB42 --rate-hz 20 --control /tmp/hub
awaits "the hub is served" grep -q ready hub.log
usbip attach -r 127.0.0.1 -b 1-1
awaits "the device is slipd's group's" eval 'stat -c %G /dev/bus/usb/*/* | grep -q "^slipd$"'
same "and no other is" "$(stat -c %G /dev/bus/usb/*/* | sort | uniq -c | awk '$2 == "slipd" { print $1 }')" 1

sensors() { slipctl --json sensors; }
systemctl start slipd || fail "it does not start: $(why)"
awaits "it answers" sensors
awaits "without the drop-in it may not use USB, and says what that takes" eval 'why | grep -q 50-usb.conf'
cp /source/systemd/slipd.service.d/50-usb.conf /run/systemd/system/slipd.service.d/
systemctl daemon-reload
systemctl restart slipd || fail "with the drop-in it does not start: $(why)"
awaits "with the drop-in frames come" eval 'slipctl --json status | grep -q "\"received\":[1-9]"'
order /tmp/hub unplug
awaits "unplugged, it is not connected" eval 'sensors | grep -q "\"connected\":false"'
order /tmp/hub plug
awaits "it is served again" usbip attach -r 127.0.0.1 -b 1-1
awaits "and read again" eval 'sensors | grep -q "\"connected\":true"'
slipctl probe | grep contactile-pts2 || fail "probe does not know it: $(slipctl probe)"
