#!/usr/bin/env bash
# Runs every test of sorairo, on the GPU too. Finds a Vulkan device, or installs Mesa's software driver where it may.
set -euo pipefail
cd "$(dirname "$0")"

quick=(--config tests/quick-window.toml)

has_vulkan() {
    cargo "${quick[@]}" run --quiet --release --package sorairo-cli --features sorairo-cli/view -- devices 2>/dev/null | grep -vq '^CPU'
}

has_linker() { command -v cc >/dev/null; }

as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi; }

install() {
    command -v apt-get >/dev/null || return 1
    as_root apt-get update -qq && as_root env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y -qq --no-install-recommends "$@" >/dev/null
}

# The X server without a screen on which the window opens.
has_xvfb() { command -v xvfb-run >/dev/null && command -v xauth >/dev/null; }

# The Python that test.sh made, from the list as it is now.
has_python() { cmp -s tests/python/requirements.txt target/python/requirements.txt; }

make_python() {
    rm -rf target/python
    mkdir -p target
    if ! python3 -m venv target/python 2>/dev/null; then
        install python3 python3-venv && python3 -m venv target/python || return 1
    fi
    target/python/bin/python -m pip install --quiet --disable-pip-version-check \
        --requirement tests/python/requirements.txt || return 1
    cp tests/python/requirements.txt target/python/
}

if ! command -v cargo >/dev/null; then
    echo "test.sh: cargo is missing; install Rust from https://rustup.rs" >&2
    exit 1
fi
if ! has_linker && ! install build-essential; then
    echo "test.sh: a C linker is missing; install gcc or clang" >&2
    exit 1
fi
echo "test.sh: building"
cargo "${quick[@]}" build --release --package sorairo-cli --features sorairo-cli/view
if ! has_vulkan; then
    echo "test.sh: no Vulkan device; installing Mesa's software driver"
    if ! install mesa-vulkan-drivers libvulkan1 || ! has_vulkan; then
        echo "test.sh: no Vulkan device. Install a Vulkan driver: on Debian and Ubuntu" >&2
        echo "    apt-get install mesa-vulkan-drivers libvulkan1" >&2
        exit 1
    fi
fi
cargo "${quick[@]}" run --quiet --release --package sorairo-cli --features sorairo-cli/view -- devices 2>/dev/null
if ! has_xvfb; then
    echo "test.sh: installing Xvfb, an X server without a screen"
    # The libraries are those that a window loads when it opens.
    if ! install xvfb xauth libxkbcommon-x11-0 libx11-xcb1 libxcursor1 libxi6 libxrandr2 || ! has_xvfb; then
        echo "test.sh: no Xvfb for the tests of the window. Install it: on Debian and Ubuntu" >&2
        echo "    apt-get install xvfb xauth libxkbcommon-x11-0 libx11-xcb1 libxcursor1 libxi6 libxrandr2" >&2
        exit 1
    fi
fi
if [ -z "${SORAIRO_PYTHON:-}" ] && ! has_python; then
    echo "test.sh: installing Python packages that read the program's files into target/python"
    if ! make_python; then
        echo "test.sh: no Python environment; install python3 with venv (Debian: apt-get install python3-venv) and give it" >&2
        echo "    a network, or set SORAIRO_PYTHON to a Python that has what tests/python/requirements.txt lists" >&2
        exit 1
    fi
fi
cargo "${quick[@]}" test --release --workspace --exclude xtask --features sorairo-cli/view
