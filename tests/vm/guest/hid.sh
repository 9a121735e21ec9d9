# hidapi sees a device made through /dev/uhid, until it is unplugged.
source /source/tests/vm/guest/check.sh

modprobe uhid
in_background device.log simulated-device vendor-hid --pattern --at uhid --serial HID42 --truth truth.jsonl --control /tmp/device
awaits "the device's node" test -e /dev/hidraw0
in_background client.log hid-client 1209 0001 14
client=$background
awaits "14 reports" grep -q "reading on" client.log
same "its serial number" "$(grep serial client.log)" "serial HID42"
same "reports have 64 bytes" "$(sed -n 3,16p client.log | awk '{ print length($0) / 2 }' | sort -u)" 64
# A report in the middle of a scan: part, parts, taxels; then taxel 10 at 11000 Pa = 2200 counts, shear 1100 and -550.
awaits "part 1 of a scan" grep -q '^..01070a98084c04dafd' client.log

order /tmp/device unplug
wait "$client" || fail "the client did not see the device go: $(cat client.log)"
same "it is gone for the client" "$(tail -n 1 client.log)" gone
awaits "the node is gone" test ! -e /dev/hidraw0
order /tmp/device plug
awaits "the node is back" test -e /dev/hidraw0
grep -q '"order":"unplug' truth.jsonl || fail "the truth does not tell of the order"
