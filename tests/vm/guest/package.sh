# The life of the packages: installed, it serves its group and nobody else; an edited configuration outlives an upgrade; purged,
# nothing is left.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/service.sh

find / -xdev -not -path '/proc/*' -not -path '/share/*' 2>/dev/null | sort >/run/before
cp /etc/passwd /etc/group /run/

installs slipd
same "it runs once it is installed" "$(systemctl is-active slipd)" active
same "it starts at boot" "$(systemctl is-enabled slipd)" enabled
people
serves | grep -q '"sensor":"left"' || fail "a member of the group is not answered: $(serves 2>&1) $(why)"
serves | grep -q '"simulated":true' || fail "the simulated sensor is not marked: $(serves)"
echo "ok: a member of the group is answered, and told that the sensor is simulated"
refused "nobody else is" as mallory slipctl gamma
as mallory slipctl gamma 2>&1 | grep -qi 'permission denied' || fail "the refusal does not say why: $(as mallory slipctl gamma 2>&1)"
same "it is not root" "$(stat -c %U "/proc/$(property MainPID)")" slipd
same "no capabilities" "$(grep CapEff "/proc/$(property MainPID)/status" | cut -f2)" 0000000000000000
refused "there are no errors in its log" eval 'journalctl -u slipd -p err --no-pager -q | grep .'

# An upgrade: the same package, called a later one, with another default configuration.
echo '// mine' >>$config
dpkg-deb -R "$packages"/slipd_*.deb /run/next
sed -i 's/^Version: .*/Version: 9.9.9-1/' /run/next/DEBIAN/control
echo '// theirs' >>/run/next/etc/slipd/slipd.json
(cd /run/next && find . -type f ! -path './DEBIAN/*' -printf '%P\0' | xargs -0 md5sum >DEBIAN/md5sums)
dpkg-deb -Znone -b /run/next /run/next.deb >/dev/null
before=$(property MainPID)
dpkg --force-confold -i /run/next.deb || fail "the upgrade is refused"
same "an upgrade keeps the edited configuration" "$(tail -n 1 $config)" "// mine"
same "and runs" "$(systemctl is-active slipd)" active
refused "and it is the new one that runs" test "$(property MainPID)" = "$before"
serves >/dev/null || fail "it does not serve after the upgrade: $(why)"

systemctl disable --now slipd.service
dpkg --force-confold -i /run/next.deb
same "what the administrator has disabled stays so over an upgrade" "$(systemctl is-enabled slipd || true)" disabled
systemctl enable --now slipd.service

dpkg -r slipd || fail "it cannot be removed"
refused "removed, it does not run" systemctl is-active slipd
test -e $config || fail "removed, not purged, it has lost its configuration"
dpkg -P slipd || fail "it cannot be purged"
userdel alice
userdel mallory
for file in passwd group; do same "$file is as before" "$(cat /etc/$file)" "$(cat /run/$file)"; done
find / -xdev -not -path '/proc/*' -not -path '/share/*' 2>/dev/null | sort >/run/after
left=$(comm -13 /run/before /run/after | grep -i slipd | grep -v '^/run/next' || true)
same "purged, nothing is left" "$left" ""
