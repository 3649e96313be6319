#!/bin/sh
# ensure_adapter.sh OCTOLUX: makes sure that there is a graphics adapter to draw with. On Linux without a Vulkan driver it
# installs Mesa's software adapter.
set -eu
octolux=$1
if "$octolux" devices >/dev/null 2>&1; then
    exit 0
fi
if [ "$(uname -s)" = Linux ]; then
    sh "$(dirname "$0")/apt_install.sh" "a Vulkan driver" libvulkan1 mesa-vulkan-drivers
fi
exec "$octolux" devices
