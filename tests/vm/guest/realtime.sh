# The packages get real time where slipd-realtime allows it: FIFO threads, locked memory. Without slipd-realtime, `enforce`
# refuses to start.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/service.sh
[[ -z ${RT-} ]] || grep -q PREEMPT_RT /proc/version || fail "this is no PREEMPT_RT kernel: $(cat /proc/version)"
installs slipd
people
cat >$config <<'JSON'
{ "sensors": [ { "name": "left", "driver": "sim", "rate_hz": 50, "stale_after_ms": 2000, "layout": { "grid": [8, 8], "pitch_mm": 1.8 } } ],
  "estimator": { "method": "moments" }, "realtime": { "mode": "enforce", "priority": 60 } }
JSON
refused "enforce does not start where it is not allowed to" systemctl restart slipd
why | grep -q 'slipd-realtime' || fail "it does not say how to allow it: $(why)"
installs slipd-realtime
systemctl reset-failed slipd
systemctl restart slipd || fail "enforce does not start although it is allowed to: $(why)"
pid=$(property MainPID)
awaits "frames are estimated" eval 'serves | grep -q "\"state\":\"\(ok\|no_contact\)\""'
policies=$(for task in /proc/"$pid"/task/*; do
  echo "$(cat "$task/comm") $(awk '{ print $40, $41 }' <(sed 's/.*) //; s/^/pid comm /' "$task/stat"))"
done | sort)
echo "$policies"
grep -q '^acq:left 60 1$' <<<"$policies" || fail "acquire has no FIFO scheduling"
grep -q '^estimate 60 1$' <<<"$policies" || fail "estimate has no FIFO scheduling"
grep -q '^slipd 0 0$' <<<"$policies" || fail "io must be scheduled as everybody"
locked=$(awk '/VmLck/ { print $2 }' "/proc/$pid/status")
((locked > 1000)) || fail "memory is not locked: $locked kB"
echo "ok: $locked kB are locked"
as alice slipctl --json status | grep -q '"lock_memory":true' || fail "status does not say so: $(as alice slipctl status)"
