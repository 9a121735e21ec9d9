# docs/first-sensor.md with nothing but the packages: a pad of 4 x 4 that a program reads, from the installation to a margin. Its
# configuration and its program are the page's; the page leaves the sensor's SDK to the reader.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/service.sh
page=/source/docs/first-sensor.md

begun=$SECONDS
installs slipd slipd-realtime python3-slipd
people
awaits "the simulated sensor of the installation" serves

sed -n "/<<'END'/,/^END/{/END/d;p}" "$page" >"$config"
# A guest without KVM runs Python so slowly that frames of 100 Hz come at 20: that shall not count as a sensor that is gone.
sed -i 's/"driver": "push",/& "stale_after_ms": 1000,/' "$config"
systemctl reload slipd
trouble=$(sed -n 's/^slipctl status *# trouble: //p' "$page")
awaits "slipctl status says what the page says: $trouble" sh -c "slipctl status | grep -qF '$trouble'"

# The SDK: a pad with an offset that is gripped, pulled by more than friction holds and let go, again and again, once there is a zero.
cat >sdk.py <<'END'
import itertools, os, random, time
frames, noise = itertools.count(), random.Random(1)
loaded = 0
def read():
    global loaded
    time.sleep(0.01)
    if os.path.exists("zeroed"): loaded = next(frames)
    at = loaded % 400
    grip, pull = (min(4.0, 0.1 * at), max(0.0, 0.02 * (at - 100))) if at < 300 else (0.0, 0.0)
    return [[0.3 + pull / 16 + noise.gauss(0, 0.001), noise.gauss(0, 0.001), 0.5 + grip / 16 * (0.8 + 0.4 * (taxel % 4 > 1)) + noise.gauss(0, 0.001)]
            for taxel in range(16)]
END
{ echo "from sdk import read"; sed -n '/^```python/,/^```/{/^```/d;p}' "$page"; } >program.py
chmod a+rx . && chmod a+r sdk.py program.py
in_background program.log as alice python3 -u program.py
awaits "the program has no zero yet" grep -aq '^unzeroed None' program.log
slipctl rebias left | grep -q 'left: zeroed' || fail "no zero"
awaits "then nothing touches the sensor" grep -aq '^no_contact' program.log
touch zeroed
awaits "a margin" grep -aEq '^ok [01]\.' program.log
awaits "an alert when it is pulled by more than friction holds" eval 'slipctl gamma left | grep -Eq "\b(warn|slip)\b"'
echo "ok: $((SECONDS - begun)) s from the packages to a margin, in a guest without KVM"
