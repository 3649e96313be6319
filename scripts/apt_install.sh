#!/bin/sh
# apt_install.sh WHAT PACKAGE...
# Installs Debian packages where that asks for no password; else prints the one command to run, and fails.
set -eu
what=$1
shift
if ! command -v apt-get >/dev/null; then
    echo "error: $what is missing. Install it with this system's package manager (Debian calls it: $*)." >&2
    exit 1
fi
if [ "$(id -u)" = 0 ]; then
    as_root=
elif sudo -n true 2>/dev/null; then
    as_root="sudo -n"
else
    echo "error: $what is missing. Run this, then start again:" >&2
    echo "    sudo apt-get update && sudo apt-get install -y $*" >&2
    exit 1
fi
echo "$what is missing: installing $*"
# One package source out of order need not matter: the installation itself tells.
$as_root apt-get update -qq </dev/null || true
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" </dev/null >/dev/null
