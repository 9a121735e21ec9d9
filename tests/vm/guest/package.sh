# The life of the packages, with apt: an older version is installed and serves its group only; its configuration is edited; the
# built packages replace it and its drivers and keep the edited file; after a purge nothing is left.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/service.sh

everything() { find / -xdev -not -path '/proc/*' -not -path '/share/*' -not -path '/run/older/*' 2>/dev/null | sort; }
everything >/run/before
cp /etc/passwd /etc/group /run/

# The same packages, called an older version, with another default configuration.
mkdir /run/older
for name in slipd slipd-driver-modbus; do
  dpkg-deb -R "$packages/${name}"_*.deb /run/older/tree
  sed -i 's/^Version: .*/Version: 0.0.9-1/; s/slipd (= [^)]*)/slipd (= 0.0.9-1)/' /run/older/tree/DEBIAN/control
  [[ $name != slipd ]] || sed -i 's/"max_clients": 64/"max_clients": 63/' /run/older/tree$config
  (cd /run/older/tree && find . -type f ! -path './DEBIAN/*' -printf '%P\0' | xargs -0 md5sum >DEBIAN/md5sums)
  dpkg-deb -Znone -b /run/older/tree "/run/older/${name}_0.0.9.deb" >/dev/null
  rm -r /run/older/tree
done
version() { dpkg-query -W -f '${Version}' "$1"; }
built=$(dpkg-deb -f "$packages"/slipd_*.deb Version)

by_apt install /run/older/slipd_0.0.9.deb
same "the older version is installed" "$(version slipd)" 0.0.9-1
same "it runs once it is installed" "$(systemctl is-active slipd)" active
same "it starts at boot" "$(systemctl is-enabled slipd)" enabled
people
serves | grep -q '"sensor":"left"' || fail "a member of the group is not answered: $(serves 2>&1)"
serves | grep -q '"simulated":true' || fail "the simulated sensor is not marked: $(serves)"
echo "ok: a member of the group is answered, and told that the sensor is simulated"
as alice slipctl watch --plain --seconds 2 | grep -q "left .* simulated$" || fail "watch does not show it"
refused "nobody else is" as mallory slipctl gamma
as mallory slipctl gamma 2>&1 | grep -q 'become a member of the group slipd' || fail "the refusal does not say why: $(as mallory slipctl gamma 2>&1)"
same "it is not root" "$(stat -c %U "/proc/$(property MainPID)")" slipd
same "no capabilities" "$(grep CapEff "/proc/$(property MainPID)/status" | cut -f2)" 0000000000000000
refused "there are no errors in its log" eval 'journalctl -u slipd -p err --no-pager -q | grep .'

# Reinstalled without a terminal, the edited file stays, without a question.
echo '// mine' >>$config
by_apt install --reinstall /run/older/slipd_0.0.9.deb
same "an edited configuration stays" "$(tail -n 1 $config)" "// mine"
by_apt install /run/older/slipd-driver-modbus_0.0.9.deb

# The upgrade of the daemon with its drivers. It brings another default configuration: the edited file stays, and the new
# default is put beside it.
before=$(property MainPID)
by_apt install -o Dpkg::Options::=--force-confold "$packages"/slipd_*.deb "$packages"/slipd-driver-modbus_*.deb
same "the daemon is the one built" "$(version slipd)" "$built"
same "and so is its driver" "$(version slipd-driver-modbus)" "$built"
same "an upgrade keeps the edited configuration" "$(grep -c '"max_clients": 63' $config) $(tail -n 1 $config)" "1 // mine"
grep -q '"max_clients": 64' $config.dpkg-dist || fail "the new default is not beside it"
same "and runs" "$(systemctl is-active slipd)" active
refused "and it is the new one that runs" test "$(property MainPID)" = "$before"
serves >/dev/null || fail "it does not serve after the upgrade"

systemctl disable --now slipd.service
by_apt install --reinstall -o Dpkg::Options::=--force-confold "$packages"/slipd_*.deb
same "what the administrator has disabled stays so" "$(systemctl is-enabled slipd || true)" disabled
same "and stopped" "$(systemctl is-active slipd || true)" inactive
systemctl enable --now slipd.service

by_apt remove slipd
refused "removed, it does not run" systemctl is-active slipd
refused "nor does its driver stay behind" test -e "$(echo /usr/lib/*/slipd)/slipd-driver-modbus.so"
test -e $config || fail "removed, not purged, it has lost its configuration"
by_apt purge slipd slipd-driver-modbus
userdel alice
userdel mallory
for file in passwd group; do same "$file is as before" "$(cat /etc/$file)" "$(cat /run/$file)"; done
everything >/run/after
same "purged, nothing is left" "$(comm -13 /run/before /run/after | grep -i slipd || true)" ""
