# SPDX-License-Identifier: MIT
# Chroots of another Debian, kept in the cache.

need_root() { # need_root WHAT: sets $root; false, or in CI a failure, where there is no root
    root=
    [ "$(id -u)" != 0 ] || return 0
    root='sudo -n'
    ! sudo -n true 2>/dev/null || return 0
    [ $werror = false ] || die "$1 needs root, for chroot"
    say "$1: skipped, it needs root for chroot"
    return 1
}

make_chroot() { # make_chroot DIR SUITE PACKAGES OPTION...: once, and anew for other packages
    chroot_dir=$1 chroot_for="$2 $3"
    [ "$(cat "$chroot_dir.made" 2>/dev/null)" != "$chroot_for" ] || return 0
    want mmdebstrap has mmdebstrap
    install_missing
    say "making a chroot of Debian $2 in $chroot_dir (once)"
    mkdir -p "$(dirname "$chroot_dir")"
    rm -f "$chroot_dir.made"
    quietly "$chroot_dir.log" patiently new_debian "$@"
    say "$chroot_for" >"$chroot_dir.made"
}

new_debian() { # the packages come from the mirror that this machine uses
    new_dir=$1 new_suite=$2 new_packages=$3
    shift 3
    mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' \
        'Label: Debian' 2>/dev/null | head -n 1)
    $root rm -rf --one-file-system "$new_dir"
    # shellcheck disable=SC2086 # nothing, or one word
    $root mmdebstrap --variant=apt --aptopt='Acquire::Languages "none"' \
        --aptopt='Acquire::Retries "5"' "$@" --include="$new_packages" "$new_suite" "$new_dir" $mirror
}

in_chroot() { # in_chroot DIR COMMAND: with /proc and /dev, which go again with the command
    # shellcheck disable=SC2016,SC2086 # for the shells below; nothing, or two words
    $root unshare --mount --pid --fork --kill-child sh -ec '
        mount --bind "$1" "$1"
        mount -t proc proc "$1/proc"
        mount --rbind /dev "$1/dev"
        exec chroot "$1" env -i HOME=/root LANG=C.UTF-8 TERM=dumb DEBIAN_FRONTEND=noninteractive \
            PATH=/usr/sbin:/usr/bin:/sbin:/bin sh -ec "$2"' sh "$1" "$2"
}
