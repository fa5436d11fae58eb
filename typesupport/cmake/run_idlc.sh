# Usage: sh run_idlc.sh OUTPUT IDLC ARGUMENT... FILE
# Runs idlc on FILE to write OUTPUT, and avoids these faults of idlc:
# - idlc cannot read the files that ROS 2's tool generates, which have no include guards. So idlc reads copies of FILE
#   and of the files that it includes (idlc_copy.awk). Messages and generated headers name the originals.
# - Some recursive types make idlc take all memory. So its memory is limited.
# - idlc returns 0 if it cannot load its generator. So OUTPUT must exist in the end.
# - Syntax errors do not say what is wrong. So idlc_messages.awk adds advice.
# Paths must be absolute, and directories must be given as -I<dir> and -b <dir>.
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

# Copies the file $1, and all files that it includes in any directory that idlc searches, to $copies.
copy() {
  [ -f "$1" ] && [ ! -e "$copies$1" ] || return 0
  mkdir -p "$copies${1%/*}" && awk -f "$script_dir/idlc_copy.awk" "$1" >"$copies$1" || return
  sed -n 's/^[[:space:]]*#[[:space:]]*include[[:space:]]*["<]\([^">]*\)[">].*/\1/p' "$1" |
    while IFS= read -r included; do
      IFS=$newline
      for dir in "${1%/*}" $include_dirs; do copy "$dir/$included" || exit; done
    done
}

# Adds the directory of copies to each argument that is a path. idlc finds files without a copy at their own path.
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
    :-r) set -- "$@" -c "$copies" ;; # -r and -c are options of SFT's generator
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
  echo "idlc did not write $output: see above; check that idlc can load its generator" >&2
  status=1
fi
exit $status
