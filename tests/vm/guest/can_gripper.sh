# The example of a gripper's loop on CAN, in a loop with a simulated gripper: it holds what is pulled at, holds firmly without slipd,
# and goes on with the next slipd.
source /source/tests/vm/guest/check.sh

modprobe vcan
ip link add vcan0 type vcan
ip link set vcan0 up
export SLIPD_BINARY_DIR=/build SLIPD_SOURCE_DIR=/source SLIPD_TEST_CAN=vcan0
export PYTHONPATH=/source/clients/python PYTHONDONTWRITEBYTECODE=1
python3 /source/tests/clients/examples_test.py Examples.test_c_on_can >test.log 2>&1 || fail "$(cat test.log)"
grep -q '^OK$' test.log || fail "it was not run: $(cat test.log)"  # OK (skipped=1)
echo "ok: the example on CAN holds the object"
