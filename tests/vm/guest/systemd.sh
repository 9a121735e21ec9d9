# slipd under the real systemd: ready when it says so, restarted by the watchdog, stopped in time.
source /source/tests/vm/guest/check.sh
same "PID 1" "$(cat /proc/1/comm)" systemd

# Libraries of the built programs, so that no test fails because one is missing.
# Bridges are not started in guests.
for file in /build/bin/slip{d,ctl,lab} /build/drivers/*.so /build/test-bin/simulated-device; do
  [[ -f $file ]] || continue
  missing=$(ldd "$file" 2>/dev/null | grep 'not found' | xargs) || true
  [[ -z $missing ]] || fail "$file: $missing: add the package to tests/vm/image/packages"
  echo "ok: $file"
done

# A copy, because slipd trusts driver modules of root only, and the build tree may belong to another user.
install -D -t /opt/slipd/bin /build/bin/slipd
install -D -t /opt/slipd/drivers /build/drivers/slipd-driver-sim.so

cat >/run/slipd.json <<'JSON'
{ "sensors": [ { "name": "left", "driver": "sim", "rate_hz": 50, "stale_after_ms": 2000,
                 "layout": { "grid": [16, 16], "pitch_mm": 0.9 } } ],
  "estimator": { "method": "moments" },
  "socket": { "path": "/run/slipd/slipd.sock" } }
JSON
cat >/run/systemd/system/slipd.service <<'UNIT'
[Service]
Type=notify
ExecStart=/opt/slipd/bin/slipd --config /run/slipd.json
DynamicUser=yes
RuntimeDirectory=slipd
WatchdogSec=5
Restart=on-failure
RestartSec=0
UNIT
systemctl daemon-reload
systemctl start slipd.service || fail "it does not start: $(journalctl -u slipd.service --no-pager)"

ask() { echo "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"$1\"}" | socat -t 5 - UNIX-CONNECT:/run/slipd/slipd.sock; }
# Readiness means that the socket answers, so nothing is awaited here.
ask version | grep -q '"name":"slipd"' || fail "the socket does not answer although it is ready: $(ask version)"
echo "ok: it answers as soon as systemctl start returns"
awaits "an estimate" eval 'ask gamma | grep -q "\"state\":\"\(ok\|no_contact\)\""'
refused "it is not root" test "$(stat -c %U "/proc/$(systemctl show -P MainPID slipd.service)")" = root

kill -STOP "$(systemctl show -P MainPID slipd.service)"
awaits "the watchdog restarts it when it stands still" eval 'test "$(systemctl show -P NRestarts slipd.service)" -ge 1'
awaits "it serves again" eval 'ask version | grep -q slipd'

systemctl stop slipd.service
same "it ends cleanly on a stop" "$(systemctl show -P Result slipd.service) $(systemctl show -P ExecMainStatus slipd.service)" "success 0"
