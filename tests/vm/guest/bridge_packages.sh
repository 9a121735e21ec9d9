# The programs beside slipd (slipd-camera, which needs much of OpenCV, is tried by tests/packages/installed), from their packages and as they are installed: an administrator enables them,
# each serves what slipd says, goes on while slipd is away, is restarted after a crash and an upgrade, and is gone after a purge.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/service.sh
bridges=(feed feed-ros2 grip grip-ros2 modbus mqtt ros2 web)
units=("${bridges[@]/#/slipd-}")
web() { python3 -c 'import sys, urllib.request as u; print(u.urlopen("http://127.0.0.1:8077" + sys.argv[1], timeout=5).read().decode())' "$1"; }
registers() {  # FIRST COUNT: the words that a PLC reads
  python3 - "$@" <<'PY'
import socket, struct, sys
first, count = map(int, sys.argv[1:])
with socket.create_connection(("127.0.0.1", 502), 5) as plc:
    plc.sendall(struct.pack(">HHHBBHH", 1, 0, 6, 1, 4, first, count))
    answer = b""
    while len(answer) < 9 + 2 * count:
        more = plc.recv(512)
        if not more:
            sys.exit("the server has closed")
        answer += more
print(*struct.unpack(f">{count}H", answer[9:]))
PY
}
fail() {
  echo "FAILED: $*"
  systemctl status --no-pager -n 20 slipd.service "${units[@]/%/.service}" || true
  exit 1
}

grep -q localhost /etc/hosts 2>/dev/null || echo 127.0.0.1 localhost >>/etc/hosts  # as an installed Debian has it
installs slipd libslipd0 "${units[@]}"
people
for unit in "${units[@]}"; do
  same "$unit waits for its administrator" "$(systemctl is-enabled $unit || true) $(systemctl is-active $unit || true)" "disabled inactive"
done
systemctl enable -q --now "${units[@]}"
for unit in "${units[@]}"; do
  same "$unit runs" "$(systemctl is-active $unit)" active
  same "$unit is no user of this system" "$(stat -c %U "/proc/$(property MainPID $unit)" | grep -c '^root$\|^slipd$' || true)" 0
done

same "slipd-grip moves nothing as installed" "$(grep -c '"dry_run": true' /etc/slipd/grip.json)" 1
awaits "a member of the group asks slipd-grip" eval 'as alice slipd-grip status | grep -q state'
refused "nobody else does" as mallory slipd-grip status
awaits "and slipd-grip-ros2 has its door for slipd-grip" test -S /run/slipd-grip-ros2/gripper.sock
same "which others than the group cannot use" "$(stat -c '%a %G' /run/slipd-grip-ros2/gripper.sock)" "660 slipd"
awaits "the page is served" eval 'web / | grep -q "<title>"'
awaits "a PLC reads a margin in state ok" eval 'read -r state frame gamma < <(registers 16 3) && [[ $state == 0 ]]'
((gamma <= 10000)) || fail "a margin in state ok is none: $gamma"
beat=$(registers 1 1)
awaits "its heartbeat goes on" eval '[[ $(registers 1 1) != "$beat" ]]'
awaits "the node takes part in its domain" eval 'ss -uln | grep -q ":7410 "'
in_background broker.log mosquitto -p 1883
awaits "a broker that comes later hears of this host" mosquitto_sub -C 1 -W 5 -t 'slipd/+/status'
mosquitto_sub -C 1 -W 30 -t 'slipd/+/status' | grep -q '"version"' || fail "its status has no version"
mosquitto_sub -C 1 -W 30 -t 'slipd/+/left/estimate' | grep -q '"sensor":"left"' || fail "there are no estimates"
echo "ok: and gets estimates"

systemctl stop slipd
awaits "a PLC is told that slipd is away" eval '[[ $(registers 2 1) == 2 ]]'
for unit in "${units[@]}"; do same "$unit goes on without slipd" "$(systemctl is-active $unit)" active; done
systemctl start slipd
awaits "and that it is back" eval '[[ $(registers 2 1) == 1 ]]'

for unit in "${units[@]}"; do
  before=$(property MainPID $unit)
  systemctl kill -s KILL $unit
  awaits "$unit is started again" eval '[[ $(property SubState $unit) == running && $(property MainPID $unit) != "$before" ]]'
done
before=$(property MainPID slipd-web)
installs slipd-web
awaits "an upgrade restarts it" eval '[[ $(property SubState slipd-web) == running && $(property MainPID slipd-web) != "$before" ]]'
for unit in "${units[@]}"; do
  systemd-analyze security --no-pager $unit.service | tail -n 1
  refused "$unit logs no error" eval "journalctl -u $unit -p err --no-pager -q _COMM=$unit | grep ."
done

by_apt purge "${units[@]}"
for unit in "${units[@]}"; do refused "$unit does not run" systemctl -q is-active $unit; done
left=()
for name in "${bridges[@]}"; do left+=(-o -name "slipd-$name*" -o -path "/etc/slipd/$name.json"); done
same "purged, nothing of them is left" "$(find /usr /etc /var/lib -false "${left[@]}" | grep -v /dpkg/ || true)" ""
same "slipd stays" "$(systemctl is-active slipd)" active
