# Usage: sh run_idlc.sh OUTPUT IDLC ARGUMENT... FILE
# Runs idlc on FILE to write OUTPUT, and makes up for what it lacks:
# - The files that ROS 2's tool generates have no include guards. So idlc reads copies of FILE and of what it includes
#   (idlc_copy.awk); its messages, and what our generator writes, name the files themselves.
# - Some recursive types make it take all memory there is.
# - It returns 0 when it cannot load its generator: only OUTPUT tells.
# - Its syntax errors do not say what is wrong (idlc_messages.awk).
# Paths are to be absolute, directories to be given as -I<dir> and -b <dir>.
output=$1
shift

set -f
script_dir=$(dirname -- "$0")
mkdir -p "$output.copies"
copies=$(cd "$output.copies" && pwd -P) || exit
trap 'rm -rf "$copies"' EXIT
newline='
'
include_dirs=

# Copies the file $1 and all that it includes, wherever idlc may look for that, to below $copies.
copy() {
  [ -f "$1" ] && [ ! -e "$copies$1" ] || return 0
  mkdir -p "$copies${1%/*}" && awk -f "$script_dir/idlc_copy.awk" "$1" >"$copies$1" || return
  sed -n 's/^[[:space:]]*#[[:space:]]*include[[:space:]]*["<]\([^">]*\)[">].*/\1/p' "$1" |
    while IFS= read -r included; do
      IFS=$newline
      for dir in "${1%/*}" $include_dirs; do copy "$dir/$included" || exit; done
    done
}

# Each argument as it is among the copies; what these lack is still found where it is.
option=
left=$#
for argument; do
  shift
  left=$((left - 1))
  original=$argument
  case $option:$argument in
    :-I*)
      include_dirs=$include_dirs${argument#-I}$newline
      set -- "$@" "-I$copies${argument#-I}"
      ;;
    -b:*) argument=$copies$argument ;;
    :-r) set -- "$@" -c "$copies" ;; # both are options of our generator
  esac
  option=
  [ "$original" != -b ] || option=-b
  [ $left -gt 0 ] || argument=$copies$original
  set -- "$@" "$argument"
done
copy "$original" || exit

rm -f "$output"
ulimit -v 2097152 # KiB
"$@" 2>"$copies/messages"
status=$?
COPIES=$copies awk -f "$script_dir/idlc_messages.awk" "$copies/messages" >&2
if [ $status -gt 128 ]; then
  echo "$original: idlc crashed (status $status): see above; it accepts some files that it cannot handle" >&2
elif [ $status -eq 0 ] && [ ! -s "$output" ]; then
  echo "idlc did not write $output: see above; could it load its generator?" >&2
  status=1
fi
exit $status
