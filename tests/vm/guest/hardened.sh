# The hardened service beyond requests: it trains a model as a child, keeps recordings that its group may read, and plays them.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/service.sh
installs slipd slipd-paper
people
sensor='"name": "left", "rate_hz": 50, "stale_after_ms": 5000, "layout": { "grid": [4, 4], "pitch_mm": 3.6 }'
answers() { serves | grep -q "\"state\":\"\($1\)\""; }

echo "{ \"sensors\": [ { $sensor, \"driver\": \"sim\" } ], \"estimator\": { \"method\": \"moments\" }, \"recorder\": { \"seconds\": 1 } }" >$config
systemctl reload slipd || fail "a good configuration is refused: $(why)"
awaits "frames are estimated" answers 'ok\|no_contact'
# The simulated contact slips again and again. No second recording starts while one is running.
recordings=/var/lib/slipd/recordings
as alice slipctl flight left
awaits "the flight recorder has kept a recording" eval "ls $recordings/left-*.rec"
recording=$(ls $recordings/left-*.rec | head -n 1)
as alice cat "$recording" >/dev/null || fail "a member of the group cannot read it: $(ls -l "$recording")"
refused "nobody else can" as mallory cat "$recording"
as alice slipctl plot "$recording"
as alice slipctl --json plot "$recording" | grep -q '"estimate":{"state":"' || fail "it has no estimates"
echo "ok: it holds estimates"
cp "$recording" /run/kept.rec
chmod 644 /run/kept.rec
recording=/run/kept.rec
flights() { as alice slipctl --json status | grep -o "\"$1\":[0-9]*" | head -n 1 | cut -d : -f 2; }
mount -t tmpfs -o size=4k tmpfs $recordings
chown slipd:slipd $recordings
awaits "a full disk costs recordings" eval '[[ $(flights failed) -ge 1 ]]'
awaits "of which nothing is left" eval '[[ -z $(ls $recordings) ]]'  # the next one may be under way
journalctl -q -o cat -u slipd SLIPD_CAUSE=machine | grep -q 'No space left on device' || fail "the log does not say why"
answers 'ok\|no_contact\|learning\|out_of_model' || fail "it does not serve on: $(serves)"
umount $recordings
kept=$(flights kept)
awaits "with room again they are kept" eval '[[ $(flights kept) -gt $kept ]]'

echo "{ \"sensors\": [ { $sensor, \"driver\": \"replay\", \"options\": { \"file\": \"$recording\", \"loop\": true } } ],
  \"estimator\": { \"method\": \"moments\" }, \"metrics\": { \"file\": \"/run/slipd/slipd.prom\", \"period_s\": 1 } }" >$config
systemctl reload slipd || fail "a good configuration is refused: $(why)"
awaits "the recording is played" eval 'serves | grep -q "\"seq\":[1-9]"'
awaits "metrics are in a file that everybody may read" eval 'as mallory grep -q "^slipd_frames_received_total{sensor=\"left\"}" /run/slipd/slipd.prom'

# More than 40 taxels: with fewer, fit is always used.
echo "{ \"sensors\": [ { ${sensor/4, 4/8, 8}, \"driver\": \"sim\" } ], \"estimator\": { \"method\": \"svd-knn\" } }" >$config
systemctl reload slipd || fail "a good configuration is refused: $(why)"
awaits "a model is being trained" eval 'why | grep -q "training a model"'
patience=240 awaits "it is trained" eval 'ls /var/lib/slipd/models/* && why | sed "/training a model/,\$!d" | grep -q "estimating by"'
as alice slipctl status
