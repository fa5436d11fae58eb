# shellcheck shell=bash
# Functions for bare systems of Debian in which tests run; scripts source this file. A system is made once, with
# debootstrap, and kept as an archive in ${XDG_CACHE_HOME:-$HOME/.cache}/sft, for the next time. Needs root, and a
# mirror of Debian: SFT_DEBIAN_MIRROR, or else the official one. If this host has an apt proxy, it is used.

mirror=${SFT_DEBIAN_MIRROR:-http://deb.debian.org/debian}

say() { printf '== %s\n' "$*"; }
die() { printf '%s: %s\n' "$(basename -- "$0")" "$*" >&2; exit 1; }

# SUITE NAME PACKAGE...: makes the archive of a bare system of that suite with these packages, unless it exists. NAME
# says what the packages are for. Another list of packages makes another archive. A package may be of another
# architecture, as in NAME:arm64, or of another suite, as in NAME/bookworm-backports. Sets archive to the file.
make_bare_system() {
  local suite=$1 name=$2 new list
  shift 2
  list=$(printf '%s\n' "$@" | md5sum)
  archive=${XDG_CACHE_HOME:-$HOME/.cache}/sft/debian-$suite-$name-${list:0:8}.tar
  [[ ! -f $archive ]] || return 0

  say "making a bare $suite (for $name)"
  new=$(mktemp -d)
  chmod 755 "$new"
  debootstrap --variant=minbase "$suite" "$new" "$mirror" >"$new.log" ||
    { tail -5 "$new.log"; die "debootstrap failed"; }
  cp /etc/resolv.conf "$new/etc/resolv.conf"
  mkdir -p "$new/etc/apt/apt.conf.d" "$new/etc/dpkg/dpkg.cfg.d"
  echo force-unsafe-io >"$new/etc/dpkg/dpkg.cfg.d/unsafe-io" # a crash of the machine loses all of it anyway
  cp /etc/apt/apt.conf.d/*proxy* "$new/etc/apt/apt.conf.d/" 2>/dev/null || true
  printf '%s\n' "$@" | sed -n 's,.*:,,p' | sort -u | xargs -rn 1 chroot "$new" dpkg --add-architecture
  printf '%s\n' "$@" | sed -n "s,.*/\(.*\),deb $mirror \1 main,p" | sort -u >"$new/etc/apt/sources.list.d/other.list"
  chroot "$new" apt-get -q update >"$new.log" || { tail -5 "$new.log"; die "apt-get update failed"; }
  chroot "$new" env DEBIAN_FRONTEND=noninteractive \
    apt-get -q install --yes --no-install-recommends "$@" >"$new.log" 2>&1 ||
    { tail -5 "$new.log"; die "the packages could not be installed"; }
  chroot "$new" apt-get clean
  mkdir -p "$(dirname -- "$archive")"
  tar -C "$new" -cf "$archive.new" .
  mv "$archive.new" "$archive"
  rm -rf --one-file-system "$new" "$new.log"
}

# FILE...: prints the packages that these files in .ci list.
packages_of() { (cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../../.ci" && sed 's/#.*//; s/[[:space:]]//g; /^$/d' "$@"); }

# Unpacks the archive and mounts the file systems that programs need. Sets system to the folder, which is removed when
# this shell exits. REQUIRES: a mount and a process namespace of its own (see in_own_namespaces), so that no mounts and
# processes are left.
open_bare_system() {
  system=$(mktemp -d)
  mount --bind "$system" "$system" # tests make namespaces, for which / has to be a mount point
  trap close_bare_system EXIT
  say "unpacking $(basename -- "$archive")"
  tar -C "$system" -xf "$archive"
  chmod 755 "$system"
  mount -t tmpfs -o mode=1777 tmpfs "$system/tmp"
  mount -t proc proc "$system/proc"
  mount --rbind --make-rslave /sys "$system/sys"
  mount --rbind --make-rslave /dev "$system/dev"
  mount -t tmpfs -o mode=1777 tmpfs "$system/dev/shm"
}

# COMMAND...: runs the command with the bare system as the root of a mount namespace. With chroot alone, programs in
# further namespaces would see paths of this host, and would not find the files beside them.
in_bare_system() {
  # shellcheck disable=SC2016 # the inner shell expands these variables
  unshare --mount --propagation private bash -euc '
    cd "$1"
    mkdir -p .host
    pivot_root . .host
    umount -l /.host
    exec "${@:2}"' bash "$system" "$@"
}

# CHECKOUT FOLDER: copies the files that git tracks or would track, in their present state.
copy_checkout() {
  mkdir -p "$2"
  git -C "$1" ls-files -z --cached --others --exclude-standard |
    tar -C "$1" --null --files-from=- --ignore-failed-read -c 2>/dev/null | tar -C "$2" -x
}

# ARGUMENT...: runs the calling script again in namespaces of its own, unless it already runs in them.
in_own_namespaces() {
  ((EUID == 0)) || die "needs root, to make a system of its own"
  [[ -z ${SFT_OWN_NAMESPACES:-} ]] || return 0
  exec env SFT_OWN_NAMESPACES=1 unshare --mount --mount-proc --pid --fork --kill-child --propagation private \
    "$0" "$@"
}

# Unmounts everything below the folder before it removes the folder, so that no mounted files are removed.
close_bare_system() {
  if [[ -n ${launcher:-} ]]; then
    kill -KILL "$launcher" 2>/dev/null || true # all processes of the system end with it
    wait "$launcher" 2>/dev/null || true
    until find "$control_group" -depth -type d -exec rmdir {} + 2>/dev/null; do sleep 0.1; done
    umount "$groups" && rmdir "$groups"
  fi
  umount --recursive --lazy "$system" && rm -rf --one-file-system "$system" "$system.log"
}

# Boots the open system with its own systemd as first process, in namespaces of its own, with a loopback device as its
# only network. Sets init to the number of that process on this host. The system ends with this shell.
boot_bare_system() {
  local log=$system.log started=$SECONDS
  echo bare >"$system/etc/hostname"
  echo 127.0.0.1 localhost bare >"$system/etc/hosts"
  say "booting $(basename -- "$archive" .tar)"
  groups=$(mktemp -d)
  mount -t cgroup2 cgroup2 "$groups"
  control_group=$(mktemp -d "$groups/sft-bare-XXXXXX")
  (
    echo "$BASHPID" >"$control_group/cgroup.procs"
    exec unshare --cgroup --mount --pid --net --ipc --uts --fork --kill-child --propagation private \
      bash -euc "$(declare -f become_init); become_init \"\$1\"" bash "$system" >"$log" 2>&1
  ) &
  launcher=$!
  until is_booted; do
    if ! kill -0 "$launcher" 2>/dev/null || ((SECONDS - started > 300)); then
      tail -20 "$log"
      die "systemd did not start"
    fi
    sleep 0.2
  done
}

# Returns true if the system has booted, and sets init. systemd calls a system degraded if a unit has failed. Some fail
# in each container, for example the one that loads modules of the kernel.
is_booted() {
  local state
  init=$(cat "/proc/$launcher/task/$launcher/children" 2>/dev/null) && init=${init%% *} && [[ -n $init ]] || return 1
  state=$(in_booted_system systemctl is-system-running 2>/dev/null) || true
  [[ $state == running || $state == degraded ]]
}

# SYSTEM: prepares the system as its first process, which then becomes systemd.
become_init() {
  local device
  cd -- "$1" || return
  ip link set lo up multicast on
  umount -R dev sys proc tmp
  mount -t proc proc proc
  mount -o bind,ro proc/sys proc/sys # the kernel's settings belong to this host, so they are read-only
  mount -t sysfs -o ro sysfs sys
  mount -t cgroup2 cgroup2 sys/fs/cgroup
  mount -t tmpfs -o mode=755 tmpfs dev
  mount -t tmpfs -o mode=755 tmpfs run
  mkdir dev/pts dev/shm
  mount -t devpts -o newinstance,ptmxmode=0666,mode=620,gid=5 devpts dev/pts
  mount -t tmpfs -o mode=1777 tmpfs dev/shm
  ln -s pts/ptmx dev/ptmx
  ln -s /proc/self/fd dev/fd
  for device in null zero full random urandom tty; do
    touch "dev/$device"
    mount --bind "/dev/$device" "dev/$device"
  done
  mount -t tmpfs -o mode=1777 tmpfs tmp
  pivot_root . .
  umount --lazy .
  exec env -i container=sft PATH=/usr/sbin:/usr/bin:/sbin:/bin /lib/systemd/systemd --log-target=journal
}

# COMMAND...: runs the command in the booted system.
in_booted_system() { nsenter --target "$init" --all env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root "$@"; }
