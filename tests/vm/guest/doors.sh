# What consumers believe while slipd, its estimate thread, a sensor or the bus dies, or the clock is set: on CAN, in shared memory and on the socket.
source /source/tests/vm/guest/check.sh

modprobe vcan
ip link add vcan0 type vcan
ip link set vcan0 up
export PYTHONPATH=/source/clients/python:/source/tests/support PYTHONDONTWRITEBYTECODE=1 SLIPD_BINARY_DIR=/build LD_LIBRARY_PATH=/build/lib SLIPD_DOORS_SLOWER=5
python3 /source/tests/doors/doors_test.py --can vcan0
