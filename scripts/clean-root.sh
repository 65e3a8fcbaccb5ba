# SPDX-License-Identifier: MPL-2.0
# Sourced by the other scripts: minimal Debian systems in folders, in which packages are built and checked.

# need_root REASON: ends the script with an explanation if the user is not root.
need_root() {
  [ "$(id -u)" -eq 0 ] || { echo "$1: run this script as root" >&2; exit 1; }
}

# make_root RELEASE FOLDER: installs a minimal Debian system (bookworm, trixie) in the folder.
make_root() {
  need_root "A Debian $1 system is installed in $2"
  need_packages mmdebstrap debian-archive-keyring
  rm -rf "$2"
  mkdir -p "$(dirname "$2")"
  mmdebstrap --quiet --variant=apt --components=main "$1" "$2"
  cp /etc/resolv.conf "$2/etc/resolv.conf" 2>/dev/null || true
  in_root "$2" apt-get update -qq
}

# in_root FOLDER COMMAND…: runs a command in the system of the folder.
in_root() {
  local folder=$1
  shift
  unshare --mount --pid --fork --mount-proc="$folder/proc" chroot "$folder" \
    env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"
}
