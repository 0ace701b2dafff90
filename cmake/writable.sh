#!/bin/sh
# Ends in one line where a build would end in many: sh cmake/writable.sh FOLDER...
set -eu
case ${1:-} in
  -h | --help) sed -n '2s/^# //p' "$0" && exit 0 ;;
esac
for folder in "$@"; do
  mkdir -p "$folder" 2>/dev/null && [ -w "$folder" ] && continue
  echo "$PWD/$folder cannot be written to: copy the checkout to where you may write, and run it there" >&2
  exit 1
done
