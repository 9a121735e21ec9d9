# A USB device is opened and closed two hundred times by libusb, which detaches and reattaches the kernel's driver each time.
# Nothing leaks.
source /source/tests/vm/guest/check.sh
modprobe vhci-hcd
in_background hub.log simulated-device papillarray --at usbip:3240 --serial USB42 --rate-hz 100
awaits "the hub is served" grep -q ready hub.log
usbip attach -r 127.0.0.1 -b 1-1
awaits "the kernel has it as a serial port" test -e /dev/ttyACM0
reopen /build/drivers/slipd-driver-usb.so '{"profile":"contactile-pts2","device":{"serial":"USB42"},"options":{"sensor":0}}' 200 ||
  fail "it leaks"
