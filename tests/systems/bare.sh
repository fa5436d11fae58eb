# shellcheck shell=bash
# Bare systems of Debian for tests, to be sourced. A system is made once, with debootstrap, and kept as an archive in
# ${XDG_CACHE_HOME:-$HOME/.cache}/sft, for the next time. Needs root, and a mirror of Debian: SFT_DEBIAN_MIRROR, or the
# official one; an apt proxy of this host is used.

mirror=${SFT_DEBIAN_MIRROR:-http://deb.debian.org/debian}

say() { printf '== %s\n' "$*"; }
die() { printf '%s: %s\n' "$(basename -- "$0")" "$*" >&2; exit 1; }

# SUITE NAME PACKAGE...: makes the archive of a bare system of that suite with these packages, unless it is there. NAME
# says what the packages are for; another list of packages makes another archive. Sets archive.
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
  echo force-unsafe-io >"$new/etc/dpkg/dpkg.cfg.d/unsafe-io" # nothing of it outlives a crash of the machine
  cp /etc/apt/apt.conf.d/*proxy* "$new/etc/apt/apt.conf.d/" 2>/dev/null || true
  chroot "$new" env DEBIAN_FRONTEND=noninteractive apt-get -q install --yes --no-install-recommends "$@" >"$new.log" ||
    { tail -5 "$new.log"; die "the packages could not be installed"; }
  chroot "$new" apt-get clean
  mkdir -p "$(dirname -- "$archive")"
  tar -C "$new" -cf "$archive.new" .
  mv "$archive.new" "$archive"
  rm -rf --one-file-system "$new" "$new.log"
}

# Unpacks the archive and mounts what programs need. Sets system, the folder. It is taken away when this shell exits.
# REQUIRES: a mount and a process namespace of its own (see in_own_namespaces), so that nothing of them is left.
open_bare_system() {
  system=$(mktemp -d)
  trap 'umount -R "$system" 2>/dev/null; rm -rf --one-file-system "$system"' EXIT
  say "unpacking $(basename -- "$archive")"
  tar -C "$system" -xf "$archive"
  chmod 755 "$system"
  mount --bind "$system" "$system" # tests make namespaces, which want / to be a mount
  mount -t tmpfs -o mode=1777 tmpfs "$system/tmp"
  mount -t proc proc "$system/proc"
  mount --rbind --make-rslave /sys "$system/sys"
  mount --rbind --make-rslave /dev "$system/dev"
  mount -t tmpfs -o mode=1777 tmpfs "$system/dev/shm"
}

# CHECKOUT FOLDER: copies what git tracks or would track, as it is now.
copy_checkout() {
  mkdir -p "$2"
  git -C "$1" ls-files -z --cached --others --exclude-standard |
    tar -C "$1" --null --files-from=- --ignore-failed-read -c 2>/dev/null | tar -C "$2" -x
}

# ARGUMENT...: runs the calling script again, in namespaces of its own, unless it is there already.
in_own_namespaces() {
  ((EUID == 0)) || die "needs root, to make a system of its own"
  [[ -z ${SFT_OWN_NAMESPACES:-} ]] || return 0
  exec env SFT_OWN_NAMESPACES=1 unshare --mount --pid --fork --kill-child --propagation private "$0" "$@"
}
