# A simulated CAN sensor is started over a real controller, sends its frames over the bus, and misbehaves on order.
source /source/tests/vm/guest/check.sh

can_up can0 can1
in_background device.log simulated-device xela-xr1944 --pattern --at can:can0 --rate-hz 5 --truth truth.jsonl --control /tmp/device
awaits "the sensor" grep -q ready device.log
captures can1 wire.log
same "it is silent until it is started" "$(wc -l <wire.log)" 0
cansend can1 201#0700
awaits "three scans" eval 'test "$(grep -c 71F# wire.log)" -ge 3'
same "the sixteen taxels of a scan, in order" "$(grep -m 1 -A 15 710# wire.log | cut -d' ' -f3 | cut -d'#' -f1 | xargs)" \
  "710 711 712 713 714 715 716 717 718 719 71A 71B 71C 71D 71E 71F"
same "the bytes of taxel 0" "$(grep -m 1 -o '710#.*' wire.log)" "710#00754975247549"

order /tmp/device lose 3
awaits "the order is carried out" grep -q '"order":"lose 3"' truth.jsonl
without_taxel_8() { grep -A 1 717# wire.log | grep -c 719#; }
awaits "three scans lack taxel 8" eval 'test "$(without_taxel_8)" = 3'

# Frames sent before it was unplugged may still be queued; a marker from the same controller comes after all of them.
order /tmp/device unplug
awaits "it is unplugged" grep -q unplug truth.jsonl
cansend can0 001#01
awaits "its last frames" grep -q '001#01' wire.log
order /tmp/device plug
awaits "it is back" grep -q '"order":"plug' truth.jsonl
cansend can0 001#02
awaits "a frame since" grep -q '001#02' wire.log
same "it was silent until it is started again" "$(sed '1,/001#01/d; /001#02/,$d' wire.log)" ""
cansend can1 201#0700
awaits "a scan" eval 'sed "1,/001#02/d" wire.log | grep -q 71F#'
