# Shared by the tests of the service: the packages, a user in the group, and requests.
PATH=${PATH#/build/bin:/build/test-bin:}  # the installed programs, not those of the build tree
packages=/source/build/${PACKAGES:-packages}
config=/etc/slipd/slipd.json

installs() {  # NAME…
  local name files=()
  for name in "$@"; do files+=("$packages/${name}"_*.deb); done
  dpkg -i "${files[@]}" || fail "dpkg refuses $*"
}

by_apt() {  # install|remove|purge NAME…: with nobody there to answer questions, and no archive to fetch from
  DEBIAN_FRONTEND=noninteractive apt-get -y -qq -o Dpkg::Use-Pty=0 "$@" </dev/null || fail "apt-get $* fails"
}

people() {  # alice is a member of group slipd, mallory is nobody in particular
  useradd --groups slipd alice
  useradd mallory
}
as() { runuser -u "$1" -- "${@:2}"; }

estimates() { as alice slipctl --json status | grep -q '"estimated":[1-9]'; }
serves() { as alice slipctl --json gamma; }
property() { systemctl show -P "$1" "${2:-slipd.service}"; }
why() { journalctl --no-pager -o cat -u slipd.service | tail -n 40; }
fail() {
  echo "FAILED: $*"
  systemctl status --no-pager -n 40 slipd.service || true
  exit 1
}
