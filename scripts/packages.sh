# SPDX-License-Identifier: MPL-2.0
# Sourced by the other scripts: Debian packages, and where things are.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

build_packages=(git g++ cmake ninja-build libeigen3-dev libsuitesparse-dev libopenblas-dev libboost-dev libcgal-dev
  libceres-dev catch2 libtomlplusplus-dev libcli11-dev nlohmann-json3-dev libvtk9-dev libgl-dev libx11-dev libgif-dev
  libpng-dev lib3mf-dev libzip-dev libspectra-dev
  libocct-foundation-dev libocct-modeling-data-dev libocct-modeling-algorithms-dev
  libocct-data-exchange-dev libocct-ocaf-dev qtbase5-dev libvtk9-qt-dev pybind11-dev python3-dev)
run_packages=(xvfb xauth libgl1-mesa-dri)
debian=$(. /etc/os-release 2>/dev/null && echo "${VERSION_CODENAME:-}" || true)
[ "$debian" = trixie ] || run_packages+=(calculix-ccx)  # Debian 13 does not have it
test_packages=(libpetsc-real-dev openmpi-bin gmsh python3-gmsh freecad-python3 python3-vtk9 python3-numpy python3-meshio python3-pil python3-pandas
  python3-scipy python3-matplotlib python3-nbclient python3-ipykernel mypy dpkg-dev file python3-jsonschema
  python3-sphinx python3-myst-parser furo python3-sphinx-copybutton python3-sphinxcontrib.bibtex)
docs_packages=(python3-sphinx python3-myst-parser furo python3-sphinx-copybutton python3-sphinxcontrib.bibtex python3-numpy)

# need_packages NAME…: installs what is missing; fast when nothing is.
need_packages() {
  local missing=()
  for p in "$@"; do
    dpkg-query -W -f='${Status}' "$p" 2>/dev/null | grep -q '^install ok installed$' || missing+=("$p")
  done
  [ ${#missing[@]} -eq 0 ] && return 0
  if ! command -v apt-get >/dev/null; then
    echo "Missing packages, and this machine has no apt-get to install them: ${missing[*]}" >&2
    echo "Batten is built on Debian 12 and 13; elsewhere install their counterparts and use cmake directly." >&2
    return 1
  fi
  local sudo=()
  if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
      echo "Missing packages: ${missing[*]}" >&2
      echo "Install them as root:  apt-get install ${missing[*]}" >&2
      return 1
    fi
    sudo=(sudo)
  fi
  echo "Installing ${#missing[@]} packages: ${missing[*]}"
  "${sudo[@]}" apt-get update -qq || true
  "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
    "${missing[@]}" >/dev/null
}

# build PRESET TARGET…: configures once, with the options in cmake_options, and builds.
build() {
  local preset=$1
  shift
  cd "$root"
  [ -f "build/$preset/build.ninja" ] || cmake --preset "$preset" ${cmake_options:-}
  cmake --build "build/$preset" --parallel "$(nproc)" ${1:+--target "$@"}
}

# display COMMAND…: with an X server, a virtual one where there is none.
display() {
  if [ -n "${DISPLAY:-}" ]; then "$@"; else xvfb-run -a "$@"; fi
}
