# Usage: sh run_outside.sh PREFIX BUILD ONE_FILE FIVE_MINUTES
# Runs the programs that were built with the SFT in PREFIX. Prints their output, and the path of the daemon's program.
# Has to run on an isolated host.
[ $PPID = 1 ] || { # otherwise it would find and stop the daemon of this machine
  echo "skipped: needs root or user namespaces"
  exit 1
}
prefix=$1 build=$2 one_file=$3 five_minutes=$4
PATH=/usr/bin:/bin
unset SFT_DAEMON
daemon=$prefix/libexec/sft/sftd
set -eu

publish_and_subscribe() {
  "$build/subscriber" &
  "$build/publisher" 20
  wait $!
}

daemons() { readlink /proc/[0-9]*/exe | grep '/sftd$' | sort -u; }

echo "== one file"
"$one_file"

echo "== the command"
"$prefix/bin/sft" pub numbers std_msgs/UInt32 'data: 7' --once --wait-for 0

echo "== the daemon in the prefix"
publish_and_subscribe
echo "daemon: $(daemons)"
"$daemon" stop

echo "== five minutes"
(
  cd "$five_minutes"
  export PATH="$prefix/bin:$PATH" CMAKE_PREFIX_PATH="$prefix"
  . ./commands.sh
  wait
)
"$daemon" stop

echo "== no daemon"
mv "$daemon" "$daemon.away"
publish_and_subscribe 2>&1

echo "== a daemon that the environment names"
SFT_DAEMON=$daemon.away publish_and_subscribe
"$daemon.away" stop
mv "$daemon.away" "$daemon"
