# libusb sees USB devices served over USB/IP like any others: vendor class, and serial ports that a driver takes over.
source /source/tests/vm/guest/check.sh
modprobe vhci-hcd

# plays MODEL VENDOR PRODUCT INTERFACE START…: two transfers arrive in $client_log, then the device is unplugged.
plays() {
  local model=$1 vendor=$2 product=$3 interface=$4
  shift 4
  client_log=$model.client
  in_background "$model.log" simulated-device "$model" --pattern --at usbip:3240 --serial USB42 --control "/tmp/$model"
  local device=$background
  awaits "$model is served" grep -q ready "$model.log"
  usbip attach -r 127.0.0.1 -b 1-1
  awaits "$model is attached" eval "grep -qi ^$vendor /sys/bus/usb/devices/*-1/idVendor"
  in_background "$client_log" usb-client "$vendor" "$product" "$interface" 3 "$@"
  local client=$background
  awaits "transfers of $model" grep -q "reading on" "$client_log"
  same "the serial number of $model" "$(grep serial "$client_log")" "serial USB42"
  order "/tmp/$model" unplug
  wait "$client" || fail "the client did not see $model go: $(cat "$client_log")"
  tail -n 1 "$client_log"
  kill "$device"
}

plays takktile 59e3 74c7 0 control C7 100
# 40 cells of 4 bytes; the first feels 1000 Pa: 386 counts, at 472 counts of temperature.
same "a transfer is a scan" "$(sed -n 4p "$client_log" | cut -c1-8) $(sed -n 4p "$client_log" | awk '{ print length($0) / 2 }')" "60807600 160"

plays robotiq-tsf85 16d0 14cc 1 bulk 9a00580101
awaits "a packet of finger 0" grep -q '^9a..583910003200' "$client_log"

plays papillarray 16c0 0483 1
awaits "a packet by its markers and table" grep -q '^556677880201001b00030027.*aabbccdd$' "$client_log"
