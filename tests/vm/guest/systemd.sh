# systemd, as PID 1, starts a notify service when the service says so, and restarts one whose watchdog starves.
source /source/tests/vm/guest/check.sh
same "PID 1" "$(cat /proc/1/comm)" systemd

unit() { printf '%s\n' "${@:2}" >"/run/systemd/system/$1"; }
unit ready.service '[Service]' Type=notify NotifyAccess=all \
  "ExecStart=/bin/sh -c 'while ! test -e /run/go; do sleep 0.05; done; systemd-notify --ready --status=running; sleep infinity'"
unit starving.service '[Service]' Type=notify NotifyAccess=all WatchdogSec=1 Restart=always RestartSec=0 \
  "ExecStart=/bin/sh -c 'systemd-notify --ready; sleep infinity'"
systemctl daemon-reload

systemctl start --no-block ready.service
awaits "it is starting" eval 'test "$(systemctl show -P ActiveState ready.service)" = activating'
touch /run/go
awaits "it is up once it has said so" systemctl is-active ready.service
same "what it says of itself" "$(systemctl show -P StatusText ready.service)" running

systemctl start starving.service
awaits "the watchdog has restarted the one that starves" eval 'test "$(systemctl show -P NRestarts starving.service)" -ge 1'
