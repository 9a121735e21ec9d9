# Clients from their packages: programs in C, C++ and Python follow the service that is installed, and nothing stays after a purge.
source /source/tests/vm/guest/check.sh
source /source/tests/vm/guest/service.sh

installs slipd libslipd0 libslipd-dev python3-slipd
people
for language in c cpp; do
  program=/build/examples/example-gripper-$language
  used=$(ldd $program | awk '$1 == "libslipd.so.0" { print $3 }')
  same "the example in $language uses the library of the package" "$(dpkg -S "$(realpath "$used")" | cut -d: -f1)" libslipd0
  in_background $language.log as alice $program left
  awaits "it follows the service" grep -q ok $language.log
  kill "$background"
done
in_background python.log as alice python3 -u -m slipd
awaits "so does the Python module" grep -q left python.log
kill "$background"
refused "a user outside the group is not served" as mallory /build/examples/example-gripper-c left
as mallory /build/examples/example-gripper-c left 2>&1 | grep -q slipd || fail "the refusal does not say by whom"
for file in /usr/include/slipd.h /usr/include/slipd.hpp "$(echo /usr/lib/*/pkgconfig/libslipd.pc)" /usr/share/man/man3/libslipd.3.gz; do
  dpkg -S "$file" | grep -q ^libslipd-dev || fail "libslipd-dev has no $file"
done
echo "ok: headers, pkg-config file and manual page are there"

by_apt purge libslipd-dev libslipd0 python3-slipd
same "purged, nothing is left" "$(find /usr /etc -name 'libslipd*' -o -name 'slipd.h*' -o -path '*python3*' -name 'slipd*')" ""
refused "the Python module neither" python3 -c 'import slipd'
