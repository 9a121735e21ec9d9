# slipd with its serial driver on the kernel's own drivers: ftdi_sio, two of QEMU's adapters end to end at 3 Mbit/s, and cdc_acm, a board
# served over USB/IP. Frames are counted, values compared; adapters go and come back.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/margin.sh

modprobe -a xhci_pci ftdi_sio cdc_acm
awaits "both adapters" test -e /dev/ttyUSB0 -a -e /dev/ttyUSB1
modprobe vhci-hcd
in_background board.log simulated-device anyskin --at usbip:3240 --serial BOARD42 --rate-hz 20 --pattern --control /tmp/board
awaits "the board is served" grep -q ready board.log
usbip attach -r 127.0.0.1 -b 1-1
awaits "the kernel has it as a serial port" test -e /dev/ttyACM0

cat >slipd.json <<'END'
{ "sensors": [ { "name": "fast", "driver": "serial", "profile": "anyskin", "device": { "path": "/dev/ttyUSB0", "baud": 3000000 }, "rate_hz": 1000,
                 "stale_after_ms": 5000 },
               { "name": "board", "driver": "serial", "profile": "anyskin", "device": { "path": "/dev/ttyACM0" }, "rate_hz": 20,
                 "stale_after_ms": 1000 } ],
  "realtime": { "mode": "off" }, "socket": { "path": "/tmp/slipd.sock" } }
END
in_background slipd.log slipd --config slipd.json
slipd=$background

# counted SENSOR MEMBER: a number of its status.
counted() {
  slipctl --socket /tmp/slipd.sock --json status | python3 -c 'import json, sys
for sensor in json.load(sys.stdin)["sensors"]:
    if sensor["name"] == sys.argv[1]:
        print(sensor[sys.argv[2]])' "$1" "$2"
}
# The pattern: taxel k presses with 1000 (k + 1), half of it along x, a quarter against y.
pattern() { slipctl --socket /tmp/slipd.sock frame "$1" | tail -n 5 | cut -d, -f3-5 | paste -sd' '; }
all_taxels="1000,500,-250 2000,1000,-500 3000,1500,-750 4000,2000,-1000 5000,2500,-1250"

awaits "the board's frames" eval '(( $(counted board received) > 10 ))'
same "value by value" "$(pattern board)" "$all_taxels"
order /tmp/board unplug
awaits "a board that is gone is a fault" is board state fault
order /tmp/board plug
awaits "it is served again" usbip attach -r 127.0.0.1 -b 1-1
awaits "and read again" is board state unzeroed

# Nothing is lost: what was sent is received, each once.
awaits "slipd has the adapter" eval 'fuser /dev/ttyUSB0 || ls -l /proc/$slipd/fd | grep -q ttyUSB0'
frames=5000
begun=$(date +%s%N)
in_background device.log simulated-device anyskin --at adapter:/dev/ttyUSB1 --rate-hz 1000 --pattern --scans $frames
awaits "all frames of a board of 1000 a second" eval '(( $(counted fast received) == frames ))'
echo "measured: $frames frames of 82 bytes in $((($(date +%s%N) - begun) / 1000000)) ms"
same "none damaged" "$(counted fast corrupt)" 0
same "value by value" "$(pattern fast)" "$all_taxels"

# Its adapter is taken out and put in again.
adapter=$(readlink -f /sys/class/tty/ttyUSB0/device/../..)
echo 0 >"$adapter/authorized"
awaits "an adapter that is gone is a fault" is fast state fault
echo 1 >"$adapter/authorized"
in_background device.log simulated-device anyskin --at adapter:/dev/ttyUSB1 --rate-hz 100 --pattern
awaits "one that is back is read again" is fast state unzeroed
kill $slipd
awaits "it ends on SIGTERM" eval '! kill -0 $slipd'
