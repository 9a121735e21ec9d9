# What guest scripts share. A script runs in /share with -eu: any command that fails ends the test.
PATH=/build/bin:/build/test-bin:$PATH

fail() {
  echo "FAILED: $*"
  dmesg | tail -n 20
  exit 1
}
skip() { echo "skipped: $*"; exit 77; }

# awaits WHAT COMMAND…: repeats the command until it succeeds, at most 300 s, or patience=SECONDS. Only a command that hangs
# takes as long. Tests await events and do not sleep.
awaits() {
  local what=$1 end=$((SECONDS + ${patience:-300}))
  shift
  until "$@" >/dev/null 2>&1; do
    ((SECONDS < end)) || fail "waited in vain for: $what"
    sleep 0.05
  done
  echo "ok: $what"
}

# same WHAT GOT EXPECTED
same() {
  [[ $2 == "$3" ]] || { printf 'got:\n%s\nexpected:\n%s\n' "$2" "$3"; fail "$1"; }
  echo "ok: $1"
}

# refused WHAT COMMAND…: it must fail.
refused() {
  local what=$1
  shift
  if "$@"; then fail "$what"; fi
  echo "ok: $what"
}

# in_background LOG COMMAND…: its process is $background, its output goes to LOG. Ends with the guest.
in_background() {
  local log=$1
  shift
  "$@" >"$log" 2>&1 </dev/null &
  background=$!
}

# can_up NAME…: controllers at 1 Mbit/s, the rate of the sensors, with a queue for several scans of 16 frames. The default of 10
# frames would lose some that a sensor on a real bus sends.
can_up() {
  local name
  modprobe kvaser_pci
  for name in "$@"; do
    ip link set "$name" type can bitrate 1000000 berr-reporting on restart-ms 100
    ip link set "$name" up txqueuelen 256
  done
}

# Frames that INTERFACE has received are in LOG. Returns once candump listens: the kernel lists its socket.
captures() {
  in_background "$2" stdbuf -oL candump -L "$1"
  awaits "candump on $1" grep -q "^ *$1 " /proc/net/can/rcvlist_all
}

# order SOCKET WORDS…: sends an order to a simulated device.
order() {
  local socket=$1
  shift
  echo "$@" | socat - "UNIX-SENDTO:$socket"
}
