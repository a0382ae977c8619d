#!/bin/bash
# Print the path of a real Blender program, Debian's own build, unpacking it first if need be.
#
#   tests/real_blender/get_blender.sh [FOLDER]
#
# As root on a Debian machine: about 2 minutes and 1 GB the first time, 1 second after. FOLDER is
# ~/.cache/iwis/real-blender by default. Nothing is installed: the packages of SUITE with all they
# need, libc included, are downloaded by the machine's apt into a state folder of their own and
# unpacked into FOLDER/root; no maintainer script runs. FOLDER can be removed at any time.
#
#   FOLDER/bin/blender     that Blender; it sees the machine's folders but /usr, /etc, /var, /lib*
#   FOLDER/bin/enter CMD   another program of that root, in the same way: Xvfb, xdotool, scrot
#
# IWIS_BLENDER_SUITE: sid (Blender 5.2, Python 3.14; the default) or trixie (4.3, Python 3.13)
# IWIS_DEBIAN_MIRROR: a Debian mirror, where apt's own sources name none
set -euo pipefail
folder=$(realpath -m "${1:-${XDG_CACHE_HOME:-$HOME/.cache}/iwis/real-blender}")
suite=${IWIS_BLENDER_SUITE:-sid}
root=$folder/root
apt=$folder/apt
say() { echo "real-blender: $*" >&2; }
fail() { say "$*"; exit 1; }

write_wrappers() {
    mkdir -p "$folder/bin"
    # A private mount namespace a call: nothing stays mounted, whatever happens to the program.
    cat > "$folder/bin/enter" <<'W'
#!/bin/sh
root=$(dirname "$(dirname "$(readlink -f "$0")")")/root
flags=-m
[ "$(id -u)" = 0 ] || flags=-rm
exec unshare $flags /bin/sh -c '
root=$1 folder=$2; shift 2
for d in /*; do
    case $d in /usr | /bin | /sbin | /lib* | /etc | /var | /boot | /lost+found) continue ;; esac
    [ -d "$d" ] && [ ! -L "$d" ] || continue
    [ -d "$root$d" ] || mkdir -p "$root$d" || continue
    mount --rbind "$d" "$root$d" || exit 125
done
[ -n "$folder" ] && [ -d "$root$folder" ] || folder=/
unset LD_LIBRARY_PATH LD_PRELOAD PYTHONHOME PYTHONPATH
PATH=/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin
exec unshare --root="$root" --wd="$folder" "$@"
' sh "$root" "$PWD" "$@"
W
    cat > "$folder/bin/blender" <<'W'
#!/bin/sh
exec "$(dirname "$(readlink -f "$0")")/enter" /usr/bin/blender "$@"
W
    chmod +x "$folder/bin/enter" "$folder/bin/blender"
}

find_mirror() {
    cat /etc/apt/sources.list /etc/apt/sources.list.d/*.list /etc/apt/sources.list.d/*.sources \
        2>/dev/null | grep -v '^ *#' | grep -oE 'https?://[^ ]+/debian/?( |$)' | head -1 | tr -d ' '
}

download() {
    local mirror key=/usr/share/keyrings/debian-archive-keyring.gpg packages
    mirror=${IWIS_DEBIAN_MIRROR:-$(find_mirror || true)}
    [ -n "$mirror" ] || fail "apt's sources name no Debian mirror; set IWIS_DEBIAN_MIRROR"
    mkdir -p "$apt/state/lists/partial" "$apt/cache/archives/partial" "$apt/none"
    echo "deb [signed-by=$key] $mirror $suite main" > "$apt/sources.list"
    : > "$apt/status"
    cat > "$apt/apt.conf" <<C
Dir::State "$apt/state";
Dir::State::status "$apt/status";
Dir::Cache "$apt/cache";
Dir::Etc::sourcelist "$apt/sources.list";
Dir::Etc::sourceparts "$apt/none";
Dir::Etc::preferences "$apt/none.pref";
Dir::Etc::preferencesparts "$apt/none";
APT::Architecture "amd64";
APT::Architectures "amd64";
APT::Install-Recommends "false";
APT::Sandbox::User "root";
Acquire::Languages "none";
Acquire::Check-Valid-Until "false";
Acquire::Retries "3";
Acquire::PDiffs "false";
C
    export APT_CONFIG=$apt/apt.conf DEBIAN_FRONTEND=noninteractive
    say "reading the package lists of $suite"
    apt-get update -qq >&2
    # Debian's blender names neither numpy nor what its extension tool imports.
    packages="blender python3-numpy python3-requests python3-zstandard
        base-files base-passwd dash coreutils libc-bin"
    if apt-cache show python3-cattr > /dev/null 2>&1; then packages="$packages python3-cattr"; fi
    # A window without a screen: X server, OpenGL in software, keys and screenshots.
    packages="$packages xvfb xauth xdotool scrot libgl1 libglx-mesa0 libegl1 libegl-mesa0
        libgl1-mesa-dri"
    say "downloading Blender"
    # shellcheck disable=SC2086
    apt-get install -y -qq --download-only $packages >&2
}

unpack() {
    dpkg-deb --fsys-tarfile "$1" | tar -x -C "$root" --keep-directory-symlink \
        --exclude='./usr/share/doc/*' --exclude='./usr/share/man/*' \
        --exclude='./usr/share/info/*' --exclude='./usr/share/locale/*' \
        --exclude='./usr/share/lintian/*' --exclude='./usr/include/*'
}

unpack_all() {
    local deb libraries=/usr/lib/x86_64-linux-gnu
    say "unpacking $(find "$apt/cache/archives" -name '*.deb' | wc -l) packages"
    mkdir -p "$root"
    unpack "$apt"/cache/archives/base-files_*.deb # the links /lib -> usr/lib come first
    for deb in "$apt"/cache/archives/*.deb; do
        unpack "$deb"
    done
    # What maintainer scripts would have done, as far as Blender needs it.
    mkdir -p "$root"/{etc/ld.so.conf.d,proc,sys,dev,tmp,run}
    printf '%s\n' $libraries/blas $libraries/lapack > "$root/etc/ld.so.conf.d/alternatives.conf"
    cp "$root/usr/share/base-passwd/passwd.master" "$root/etc/passwd"
    cp "$root/usr/share/base-passwd/group.master" "$root/etc/group"
    ln -sfn /proc/self/mounts "$root/etc/mtab"
    chroot "$root" /usr/sbin/ldconfig
    rm -rf "$apt"
}

version() {
    "$folder/bin/blender" -b --version 2>/dev/null | sed -n 's/^Blender //p;' | head -1
}

stamp="$suite with a window"
mkdir -p "$folder"
exec 9> "$folder/turn"
flock 9 # who asks while another unpacks waits for it
if [ "$(cat "$folder/suite" 2>/dev/null)" = "$stamp" ] && [ -n "$(version)" ]; then
    echo "$folder/bin/blender"
    exit 0
fi
[ "$(id -u)" = 0 ] || fail "must be root to unpack Debian's Blender"
for tool in apt-get dpkg-deb unshare chroot; do
    command -v "$tool" > /dev/null || fail "$tool is missing: a Debian machine is needed"
done
rm -rf "$folder/suite" "$root" "$apt"
download
unpack_all
write_wrappers
[ -n "$(version)" ] || fail "Blender does not start: $("$folder/bin/blender" -b --version 2>&1 | tail -1)"
echo "$stamp" > "$folder/suite"
say "Blender $(version) in $folder"
echo "$folder/bin/blender"
