#!/bin/bash
# completion_test.sh BUILD: the shell completes the options of each bridge, and files behind those that take one.
set -euo pipefail
build=$1
completes() {  # FUNCTION WORD… : what it offers for the last one
  local function=$1
  shift
  COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
  "$function"
  echo "${COMPREPLY[*]}"
}
same() { [[ $1 == "$2" ]] || { echo "expected \"$1\", got \"$2\"" >&2; exit 1; }; }

count=0
for file in "$build"/completion/slipd-*; do
  name=${file##*/}
  [[ -x $build/bin/$name ]] || continue
  # shellcheck source=/dev/null
  . "$file"
  same --check-config "$(completes "_${name/-/_}" "$build/bin/$name" --check)"
  same "--config --check-config" "$(completes "_${name/-/_}" "$build/bin/$name" --c)"
  same "$build/bin" "$(completes "_${name/-/_}" "$build/bin/$name" --config "$build/bi")"
  count=$((count + 1))
done
(( count > 0 )) || { echo "no bridge is built" >&2; exit 1; }
echo "$count programs"
