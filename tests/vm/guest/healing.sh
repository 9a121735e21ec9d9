# The service recovers after a kill, a stop and a bad configuration, and takes up a good configuration without losing its
# clients.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/service.sh
installs slipd
people

restarted() { [[ $(property NRestarts) -gt $restarts && $(systemctl is-active slipd) == active ]] && serves; }
restarts=$(property NRestarts)
kill -KILL "$(property MainPID)"
awaits "killed, it comes back and serves" restarted
restarts=$(property NRestarts)
kill -STOP "$(property MainPID)"
awaits "standing still, it is restarted and serves" restarted

# A client that stays connected during a reload; its stream goes on.
cat >$config <<'JSON'
{ "sensors": [ { "name": "left", "driver": "sim", "rate_hz": 50, "stale_after_ms": 2000, "layout": { "grid": [8, 8], "pitch_mm": 1.8 } } ],
  "estimator": { "method": "moments" } }
JSON
systemctl reload slipd || fail "a good configuration is refused: $(why)"
pid=$(property MainPID)
in_background watched as alice slipctl --json watch --rate 10
watcher=$background
awaits "a client follows" grep -q '"sensor":"left"' watched
sed -i 's/"left"/"right"/' $config
systemctl reload slipd || fail "a good configuration is refused: $(why)"
awaits "the new sensor is there" eval 'serves | grep -q "\"sensor\":\"right\""'
same "in the same process" "$(property MainPID)" "$pid"
awaits "the client gets estimates of the new sensor" grep -q '"sensor":"right"' watched
kill -0 "$watcher" || fail "the client is gone: $(cat watched)"
pkill -u alice slipctl  # `as` is another process; a client that is left behind would wake the socket below
awaits "the client has ended" eval '! pgrep -u alice slipctl'

sed -i 's/"rate_hz": 50/"rate_hz": -50/' $config
refused "systemctl reload fails where the configuration is bad" systemctl reload slipd
why | grep -q '/sensors/0/rate_hz' || fail "the log does not say where: $(why)"
kill -HUP "$pid"
awaits "the daemon itself refuses it, too" eval 'why | grep -q "reload: .*/sensors/0/rate_hz"'
same "it goes on" "$(property MainPID) $(systemctl is-active slipd)" "$pid active"
serves | grep -q '"sensor":"right"' || fail "the old configuration is not in force: $(serves)"
systemctl restart slipd || true
same "a bad configuration is not tried again and again" "$(property ExecMainStatus) $(property NRestarts)" "2 0"
sed -i 's/"rate_hz": -50/"rate_hz": 50/' $config

systemctl reset-failed slipd
systemctl disable slipd.service
systemctl enable --now slipd.socket
same "the socket waits, the service does not run" "$(systemctl is-active slipd.socket) $(systemctl is-active slipd.service)" "active inactive"
serves | grep -q '"sensor":"right"' || fail "the socket does not start it: $(why)"
echo "ok: the first question starts it"
refused "the socket lets no non-member in" as mallory slipctl gamma
systemctl stop slipd.service
serves >/dev/null || fail "stopped, it is not started again by the next question: $(why)"
echo "ok: and again after a stop"
