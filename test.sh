#!/usr/bin/env bash
# Runs every test of sorairo, including those on the GPU, whichever fail. The last line says whether any failed.
# `./test.sh quick` takes minutes: unit tests, kernels on the device relative to the CPU, the command, the documents.
# The tests need a linker, a Vulkan driver, an X server without a screen, Chromium, npm, and Python with venv. As root
# on Debian or a relative, the script installs what is missing with apt-get; otherwise it prints what to install. It uses
# no other rights.
set -euo pipefail
cd "$(dirname "$0")"

quick=(--config tests/quick-window.toml)

sorairo=${CARGO_TARGET_DIR:-target}/release/sorairo

case "${1:-all}" in
all | quick) ;;
*)
    echo "test.sh: $1 is no choice; it is all (the default) or quick" >&2
    exit 2
    ;;
esac

has_vulkan() { "$sorairo" devices 2>/dev/null | grep -vq '^CPU'; }

has_linker() { command -v cc >/dev/null || [ "${OS:-}" = Windows_NT ]; }

# Installs Debian packages where that is allowed; says what it does, or what there is to do.
install() {
    if [ "$(id -u)" != 0 ] || ! command -v apt-get >/dev/null; then
        echo "test.sh: not root on Debian, so nothing is installed here. On Debian and Ubuntu: apt-get install $*" >&2
        return 1
    fi
    echo "test.sh: apt-get install $*"
    apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >/dev/null
}

# The X server without a screen on which the window opens.
has_xvfb() { command -v xvfb-run >/dev/null && command -v xauth >/dev/null; }

# The browser in which the page is tested.
has_chromium() { command -v chromium >/dev/null; }

# npm, by which the tests of its package fetch three.js and TypeScript.
has_npm() { command -v npm >/dev/null; }

# Builds the page, and tests it in the browser.
test_page() {
    local python=${SORAIRO_PYTHON:-target/python/bin/python}
    cargo xtask web && "$python" -m pytest --quiet -p no:cacheprovider tests/web
}

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

# A Python that Blender takes, which is one version alone.
python_of_blender() {
    local python
    for python in python3 python3.11; do
        if "$python" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null; then
            echo "$python"
            return
        fi
    done
    return 1
}

# The Python with Blender that test.sh made, from the list as it is now.
has_blender() { [ -n "${SORAIRO_BLENDER:-}" ] || cmp -s tests/python/blender.txt target/blender/blender.txt; }

make_blender() {
    local python
    python=$(python_of_blender) || return 1
    echo "test.sh: installing Blender into target/blender: 374 MB to fetch, 1 GB on the disk"
    rm -rf target/blender
    "$python" -m venv target/blender && target/blender/bin/python -m pip install --quiet --disable-pip-version-check \
        --requirement tests/python/blender.txt && cp tests/python/blender.txt target/blender/
}

test_blender() {
    if ! has_blender && ! make_blender; then
        echo "test.sh: NOT TESTED: environment maps in Blender, which takes Python 3.11, or SORAIRO_BLENDER set to a Python with bpy" >&2
        return
    fi
    cargo "${tests[@]}" --test program -- --ignored blender
}

# Builds the wheel, and tests it in an environment made for it: numpy comes with the wheel, and what the tests compare
# it with from the Python that has it.
test_wheel() {
    local python=${SORAIRO_PYTHON:-target/python/bin/python} fresh=target/wheel/bin/python
    local site='import site; print(site.getsitepackages()[0])'
    rm -rf target/wheels target/wheel
    "$python" -m maturin build --quiet --release --locked --manifest-path host/python/Cargo.toml "${quick[@]}" \
        --interpreter "$python" --compatibility linux --out target/wheels &&
        "$python" -m venv target/wheel &&
        "$fresh" -m pip install --quiet --disable-pip-version-check --constraint tests/python/requirements.txt target/wheels/*.whl &&
        "$python" -c "$site" >"$("$fresh" -c "$site")/peers.pth" &&
        "$fresh" -m pytest --quiet -p no:cacheprovider host/python/tests
}

if ! command -v cargo >/dev/null; then
    echo "test.sh: cargo is missing; install Rust from https://rustup.rs" >&2
    exit 1
fi
if ! has_linker && ! install build-essential; then
    echo "test.sh: a C linker is missing" >&2
    exit 1
fi
echo "test.sh: building"
# Beside the Python package and the tests, which ask for more of some crates: all that follows takes what is built here.
cargo "${quick[@]}" build --release --package sorairo-cli --package sorairo-python --package sorairo-tests --bin sorairo \
    --features sorairo-cli/view
if ! has_vulkan; then
    if ! install mesa-vulkan-drivers libvulkan1 || ! has_vulkan; then
        echo "test.sh: no Vulkan device; the tests need one, and Mesa's software driver will do" >&2
        exit 1
    fi
fi
"$sorairo" devices 2>/dev/null
tests=("${quick[@]}" test --release --workspace --exclude xtask --features sorairo-cli/view)
if [ "${1:-all}" = quick ]; then
    cargo "${tests[@]}" --lib --test documents --test input || failed=1
    cargo "${tests[@]}" --test devices -- gpu:: shaders:: || failed=1
    cargo "${tests[@]}" --test program -- cli:: scenes:: || failed=1
    exit "${failed:-0}"
fi
if ! has_xvfb; then
    # The libraries are those that a window loads when it opens.
    if ! install xvfb xauth libxkbcommon-x11-0 libx11-xcb1 libxcursor1 libxi6 libxrandr2 || ! has_xvfb; then
        echo "test.sh: no Xvfb, the X server without a screen on which the tests open the window" >&2
        exit 1
    fi
fi
if ! has_chromium; then
    if ! install chromium || ! has_chromium; then
        echo "test.sh: no chromium, the browser in which the tests open the page" >&2
        exit 1
    fi
fi
if ! has_npm; then
    if ! install npm || ! has_npm; then
        echo "test.sh: no npm, which fetches what the tests of its package take" >&2
        exit 1
    fi
fi
if [ -z "${SORAIRO_PYTHON:-}" ] && ! has_python; then
    echo "test.sh: installing Python packages that read the program's files into target/python"
    if ! make_python; then
        echo "test.sh: no Python environment: it takes python3 with venv and a network; or set SORAIRO_PYTHON to a Python" >&2
        echo "    that has what tests/python/requirements.txt lists" >&2
        exit 1
    fi
fi
# What other people's programs take, mostly a core at a time, runs beside the tests, and is told after them.
test_others() {
    local failed=0
    test_wheel || failed=1
    test_blender || failed=1
    # What takes minutes of other people's programs.
    cargo "${tests[@]}" --test sky -- --ignored || failed=1
    test_page || failed=1
    # The library as one takes it that needs neither Vulkan nor files. It renders three small pictures, and is hardly
    # optimised for them.
    cargo "${quick[@]}" --config 'profile.release.package.sorairo.opt-level=1' \
        --config 'profile.release.package.sorairo-shared.opt-level=1' \
        test --release --package sorairo --no-default-features --features cpu --test cpu_only || failed=1
    return "$failed"
}

# Else an interrupted test.sh would leave them running.
trap 'trap - INT TERM; kill 0' INT TERM
others=target/others.log
test_others >"$others" 2>&1 &
cargo "${tests[@]}" --no-fail-fast || failed=1
wait "$!" || failed=1
echo "test.sh: beside these"
cat "$others"
[ -z "${failed:-}" ] || echo "test.sh: FAILED"
exit "${failed:-0}"
