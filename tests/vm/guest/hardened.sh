# What slipd does besides answering, done by the hardened service: it trains a model as a child, keeps recordings that its group may
# read, and plays them.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/service.sh
installs slipd
people
sensor='"name": "left", "rate_hz": 50, "stale_after_ms": 5000, "layout": { "grid": [4, 4], "pitch_mm": 3.6 }'
answers() { serves | grep -q "\"state\":\"\($1\)\""; }

echo "{ \"sensors\": [ { $sensor, \"driver\": \"sim\" } ], \"estimator\": { \"method\": \"moments\" }, \"recorder\": { \"seconds\": 1 } }" >$config
systemctl reload slipd || fail "a good configuration is refused: $(why)"
awaits "frames are estimated" answers 'ok\|no_contact'
as alice slipctl flight left
awaits "the flight recorder has kept a recording" eval 'ls /var/lib/slipd/recordings/left-*-request.rec'
recording=$(ls /var/lib/slipd/recordings/left-*-request.rec)
as alice cat "$recording" >/dev/null || fail "a member of the group cannot read it: $(ls -l "$recording")"
refused "nobody else can" as mallory cat "$recording"

echo "{ \"sensors\": [ { $sensor, \"driver\": \"replay\", \"options\": { \"file\": \"$recording\", \"loop\": true } } ],
  \"estimator\": { \"method\": \"moments\" } }" >$config
systemctl reload slipd || fail "a good configuration is refused: $(why)"
awaits "the recording is played" eval 'serves | grep -q "\"seq\":[1-9]"'

echo "{ \"sensors\": [ { $sensor, \"driver\": \"sim\" } ], \"estimator\": { \"method\": \"svd-knn\" } }" >$config
systemctl reload slipd || fail "a good configuration is refused: $(why)"
awaits "a model is being trained" eval 'why | grep -q "training a model"'
patience=240 awaits "it is trained" eval 'ls /var/lib/slipd/models/* && why | sed "/training a model/,\$!d" | grep -q "estimating by"'
as alice slipctl status
