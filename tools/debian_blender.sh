#!/usr/bin/env bash
# What scripts/blender does: a real Blender on a Debian-like machine; prints the command that runs it.
#
# A stable Debian has no current Blender, so a small Debian of another suite is made in a folder of its own
# (PT_BLENDER_DIR, else ~/.cache/pt_engine/blender) from the mirror that this machine's apt uses, and run with
# chroot in a mount namespace that ends with the call. Safe to run again. Needs root, 1.5 GB and a few minutes.
set -euo pipefail
suite=${PT_BLENDER_SUITE:-sid}
dir=${PT_BLENDER_DIR:-${XDG_CACHE_HOME:-$HOME/.cache}/pt_engine/blender}
root=$dir/$suite
# cattr: else the extension system doesn't register. Mesa, Xvfb and xdotool: for the tests of the window.
packages="blender python3-numpy python3-cattr python3-openimageio python3-requests python3-zstandard
          xvfb libgl1-mesa-dri libegl1 xkb-data xdotool ca-certificates"
say() { echo "scripts/blender: $*" >&2; }
die() { say "$*"; exit 1; }

if [ ! -e "$root/.complete" ]; then
    [ "$(id -u)" = 0 ] || die "must be run as root, to make a chroot"
    unshare --mount true 2>/dev/null || die "this container may not mount (it lacks CAP_SYS_ADMIN)"
    if [ -z "${PT_BLENDER_INSIDE:-}" ]; then     # all mounts below end with this process
        PT_BLENDER_INSIDE=1 exec unshare --mount --propagation private "$BASH" "$0"
    fi
    mkdir -p "$dir"
    exec 9>"$dir/.lock"; flock 9                 # one at a time
    mirror=$(apt-get indextargets --format '$(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' |
        awk '$3 == "main" && $2 !~ /security|updates|backports/ { print $1; exit }')
    [ -n "$mirror" ] || die "apt's sources on this machine name no Debian mirror"
    part=$dir/.part log=$dir/install.log
    logged() { "$@" >>"$log" 2>&1 || { tail -n 25 "$log" >&2; die "failed: $* (all of it: $log)"; }; }
    : >"$log"
    if ! command -v debootstrap >/dev/null; then
        logged apt-get update
        logged env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends debootstrap
    fi
    rm -rf --one-file-system "$part"
    say "making a small Debian $suite (log: $log)"
    logged debootstrap --variant=minbase "$suite" "$part" "$mirror"
    # the machine's own way to the network
    apt-config dump | grep -E '^Acquire::(http|https|Retries|Check-|ForceIPv)' >"$part/etc/apt/apt.conf.d/10machine" || true
    for f in /etc/apt/auth.conf /etc/apt/auth.conf.d /etc/resolv.conf /etc/ssl/certs/ca-certificates.crt; do
        [ ! -e "$f" ] || { mkdir -p "$part$(dirname "$f")"; cp -aL "$f" "$part$(dirname "$f")/" || true; }
    done
    echo "deb $mirror $suite main" >"$part/etc/apt/sources.list"
    echo force-unsafe-io >"$part/etc/dpkg/dpkg.cfg.d/fast"
    printf '#!/bin/sh\nexit 101\n' >"$part/usr/sbin/policy-rc.d"; chmod 755 "$part/usr/sbin/policy-rc.d"
    ln -sf /proc/self/mounts "$part/etc/mtab"
    for p in proc dev sys; do mount --rbind "/$p" "$part/$p"; done
    inside() { env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive chroot "$part" "$@"; }
    say "installing Blender in it"
    logged inside apt-get update
    logged inside apt-get install -y --no-install-recommends $packages
    logged inside apt-get clean
    for p in proc dev sys; do umount -R "$part/$p"; done
    [ ! -e "$root" ] || rm -rf --one-file-system "$root"
    mv "$part" "$root"; : >"$root/.complete"
fi

# run-inside PROGRAM …: a program of the chroot, with the machine's own folders at their places
cat >"$dir/run-inside.new" <<'RUN'
#!/usr/bin/env bash
set -u
root=$(dirname "$(readlink -f "$0")")/@SUITE@
if [ "${1:-}" != --inside ]; then
    own=(); [ "$(id -u)" = 0 ] || own=(--user --map-root-user)
    exec unshare --mount --propagation private "${own[@]}" "$BASH" "$0" --inside "$PWD" "$@"
fi
shift; cwd=$1; shift
for p in /*; do
    case $p in /bin | /boot | /etc | /lib* | /lost+found | /run | /sbin | /usr | /var) continue ;; esac
    [ -d "$p" ] && [ ! -L "$p" ] && mkdir -p "$root$p" && mount --rbind "$p" "$root$p"
done
unset LD_LIBRARY_PATH LD_PRELOAD PYTHONHOME PYTHONPATH VIRTUAL_ENV LC_ALL
export PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8
exec chroot "$root" /usr/bin/env --chdir="$cwd" "$@"
RUN
sed -i "s/@SUITE@/$suite/" "$dir/run-inside.new"
printf '#!/bin/sh\nexec "$(dirname "$(readlink -f "$0")")/run-inside" blender "$@"\n' >"$dir/blender.new"
for f in run-inside blender; do chmod 755 "$dir/$f.new"; mv "$dir/$f.new" "$dir/$f"; done
"$dir/blender" -b --factory-startup --python-exit-code 9 --python-expr 'import numpy' >/dev/null ||
    { rm -f "$root/.complete"; die "Blender was installed but does not start"; }
echo "$dir/blender"
