# CAN frames cross a virtual bus, and two controllers on one wire, from program to program and from a sensor.
source /source/tests/vm/guest/check.sh

modprobe vcan
ip link add vcan0 mtu 72 type vcan
ip link set vcan0 up
captures vcan0 vcan.log
cansend vcan0 710#00112233445566
cansend vcan0 12345678#DEADBEEF
cansend vcan0 123#R
cansend vcan0 123##100112233445566778899AABB
awaits "the last frame" grep -q '123##' vcan.log
# The kernel adds the flag FDF (4) to the bit rate switch (1).
same "classic, extended, remote and FD frames on the virtual bus" "$(cut -d' ' -f3 vcan.log)" \
  "710#00112233445566
12345678#DEADBEEF
123#R
123##500112233445566778899AABB"

# A simulated sensor sends on the same bus once it is started: iCub's skin, two frames a triangle.
in_background skin.log simulated-device icub-skin --pattern --rate-hz 5 --at can:vcan0
awaits "the skin" grep -q ready skin.log
cansend vcan0 201#0700
awaits "a scan of four triangles" grep -q '413#80' vcan.log
same "the taxels of the first" "$(grep -m 2 -o '410#.*' vcan.log | xargs)" "410#00F3F1EFEDEBE9E7 410#80E5E3E1DFDD0000"

can_up can0 can1
captures can1 wire.log
for i in $(seq 1 50); do cansend can0 "710#$(printf %04x "$i")"; done
awaits "50 frames over the wire" eval 'test "$(wc -l <wire.log)" = 50'
same "in their order" "$(cut -d'#' -f2 wire.log | xargs)" "$(for i in $(seq 1 50); do printf '%04X\n' "$i"; done | xargs)"

ip link set vcan0 down
refused "nothing is sent on a bus that is down" cansend vcan0 710#00
