# slipd-camera on the kernel's own Video4Linux: pictures of a gel through a loopback, with faults, and a camera of the kernel's test
# driver vivid, whose formats and controls are set and which is unplugged.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/margin.sh
export LD_LIBRARY_PATH=/build/vm/camera-libraries
[[ -x /build/bin/slipd-camera ]] || skip "slipd-camera is not built"

modprobe v4l2loopback video_nr=9 card_label=gel
modprobe vivid n_devs=1 node_types=0x1 vid_cap_nr=8
awaits "both cameras" test -e /dev/video9 -a -e /dev/video8

cat >slipd.json <<'END'
{ "sensors": [ { "name": "gel", "driver": "push", "layout": { "grid": [6, 4], "pitch_mm": 2 }, "rate_hz": 10, "stale_after_ms": 1500,
                 "options": { "unit": "mm" } },
               { "name": "test", "driver": "push", "layout": { "grid": [6, 4], "pitch_mm": 2 }, "rate_hz": 10, "stale_after_ms": 1500,
                 "options": { "unit": "mm" } } ],
  "realtime": { "mode": "off" }, "socket": { "path": "/tmp/slipd.sock" } }
END
profile() {  # FORMAT FOLLOW CONTROLS WIDTH HEIGHT
  echo "{ \"description\": \"$1\", \"picture\": { \"width\": $4, \"height\": $5, \"rate_hz\": 10, \"format\": \"$1\" }, \"controls\": { $3 },
  \"surface\": { \"follow\": \"$2\", \"mm_per_px\": 0.1 }, \"nodes\": { \"rows\": 4, \"columns\": 6, \"pitch_mm\": 2 } }"
}
profile mjpeg dots '' 160 120 >gel.json
profile yuyv texture '"brightness": 100, "gain": 60, "gain_automatic": 0' 320 180 >yuyv.json
profile grey texture '' 320 180 >grey.json
profile mjpeg texture '' 320 180 >mjpeg.json
profile yuyv texture '"focus": 3' 320 180 >focus.json
echo '{ "sensor": "gel", "device": "/dev/video9", "profile": "./gel.json", "socket": "/tmp/slipd.sock" }' >camera.json
echo '{ "sensor": "test", "device": "/dev/video8", "profile": "./yuyv.json", "socket": "/tmp/slipd.sock" }' >vivid.json

in_background slipd.log slipd --config slipd.json
awaits "slipd" test -S /tmp/slipd.sock

# A camera of dots.
in_background simulated.log simulated-camera /dev/video9 --control /tmp/camera --rate-hz 10
in_background camera.log slipd-camera --config camera.json
# Stale, and a fault when nothing has come for longer.
silent() { is "$1" state stale || is "$1" state fault; }
displaced() { near gel displacement_mm "$1" "$2"; }
awaits "a gel at rest" displaced 0 0.02
order /tmp/camera press 8 0
awaits "a gel that is dragged by 0.8 mm in its middle" eval 'awk -v d="$(of gel displacement_mm)" "BEGIN { exit !(d > 0.2 && d < 0.8) }"'
same "and no margin" "$(of gel gamma)" null
order /tmp/camera press 0 0
awaits "it is let go" displaced 0 0.02

# What a camera does that is not well: nothing is told of such pictures.
order /tmp/camera freeze
awaits "a picture that stands still" silent gel
order /tmp/camera go
awaits "and moves again" displaced 0 0.02
order /tmp/camera torn
awaits "pictures that are torn" silent gel
order /tmp/camera whole
awaits "and whole again" displaced 0 0.02
order /tmp/camera light 0.1
awaits "the lamp goes out" silent gel
order /tmp/camera light 0.7
awaits "a dimmer lamp is no displacement" displaced 0 0.05
order /tmp/camera flicker 1.3
before=$(of gel seq)
awaits "fifty pictures of an exposure that pulses" eval '(($(of gel seq) > before + 50))'
awaits "are no displacement" displaced 0 0.05
same "nor an alert" "$(of gel alert)" none
order /tmp/camera flicker 1
order /tmp/camera pause
awaits "a camera that hangs" silent gel
awaits "slipd-camera says so" grep -q "/dev/video9: sends no pictures" camera.log
order /tmp/camera go
awaits "and works again" displaced 0 0.05

# Fewer pictures than the profile says, as where the light is poor: 18 for each 25.
order /tmp/camera rate 7.2
order /tmp/camera press 8 0
awaits "a gel that is held" eval 'awk -v d="$(of gel displacement_mm)" "BEGIN { exit !(d > 0.2 && d < 0.8) }"'
before=$(of gel seq)
awaits "for thirty pictures" eval '(($(of gel seq) > before + 30))'
order /tmp/camera press 0 0
awaits "slips away, and is told" is gel alert slip

# Formats and controls, by the kernel's test driver.
for format in yuyv grey; do
  slipd-camera --device /dev/video8 --profile ./$format.json --frames $format.frames --pictures 5 || fail "pictures in $format"
  same "five frames of $format, behind a hello" "$(($(stat -c %s $format.frames) > 5 * 4 * 6 * 3 * 4))" 1
done
same "a control of the profile is set" "$(python3 /source/tests/vm/programs/v4l2-control /dev/video8 Brightness)" 100
same "after its automatic was switched off" "$(python3 /source/tests/vm/programs/v4l2-control /dev/video8 Gain)" 60
refused "a format that the camera has not" slipd-camera --device /dev/video8 --profile ./mjpeg.json --frames - 2>refused.log
awaits "it says what there is instead" grep -q "has no pictures of 320 x 180 MJPG, it offers" refused.log
refused "a control that it has not" slipd-camera --device /dev/video8 --profile ./focus.json --frames - 2>refused.log
awaits "it says which" grep -q 'has no control "focus"' refused.log

# Unplugged.
in_background vivid.log slipd-camera --config vivid.json
awaits "the other camera's frames" eval '(( $(of test seq) > 3 ))'
python3 /source/tests/vm/programs/v4l2-control /dev/video8 Disconnect 1
awaits "it is gone" silent test
awaits "slipd-camera says so" grep -q "/dev/video8" vivid.log
echo vivid.0 >/sys/bus/platform/drivers/vivid/unbind
echo vivid.0 >/sys/bus/platform/drivers/vivid/bind
awaits "and there again" eval '! silent test'
