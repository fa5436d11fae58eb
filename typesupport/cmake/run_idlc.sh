# Usage: sh run_idlc.sh OUTPUT IDLC ARGUMENT...
# Runs idlc, which is to write OUTPUT. Its memory is bounded: some recursive types make it take all there is. And it
# returns 0 when it cannot load the generator, so that only the output tells.
output=$1
shift
rm -f "$output"
ulimit -v 2097152 # KiB
"$@" || exit
if [ ! -s "$output" ]; then
  echo "idlc did not write $output: see above; could it load its generator?" >&2
  exit 1
fi
