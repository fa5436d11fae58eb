# Usage: sh quietly.sh COMMAND...: shows what COMMAND prints only if it fails.
output=$("$@" 2>&1) && exit
status=$?
printf '%s\n' "$output" >&2
exit $status
