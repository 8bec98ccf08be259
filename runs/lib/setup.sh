# shellcheck shell=bash disable=SC2034,SC2086,SC2154
# Shared by runs/quickstart and tests/run (sourced by bash): packages, BLAS, environment, build.
# The caller sets `root` to the root of the repository.

PACKAGES_BUILD="build-essential cmake ninja-build pkg-config petsc-dev libslepc-real-dev libmumps-dev libmetis-dev libopenmpi-dev openmpi-bin
libhdf5-openmpi-dev libgmsh-dev libcgal-dev libgmp-dev libmpfr-dev libopenblas0-pthread libeigen3-dev libtomlplusplus-dev libmuparser-dev libcli11-dev libfmt-dev nlohmann-json3-dev libpugixml-dev libboost-dev doctest-dev
libembree-dev libtbb-dev libpng-dev libwebp-dev libgif-dev libstb-dev fonts-dejavu-core libjs-three
python3-h5py python3-numpy python3-dev pybind11-dev"
PACKAGES_TEST="clang-14 clang-format-14 clang-tidy-14 python3-pil python3-scipy python3-mpi4py python3-petsc4py python3-sphinx
python3-myst-parser libjs-mathjax"

say() { printf '== %s\n' "$*"; }

# Runs a command as root: directly, or through sudo if it needs no password or can ask for one.
as_root() {
  if [ "$(id -u)" = 0 ]; then
    "$@"
  else
    sudo "$@"
  fi
}

can_be_root() {
  [ "$(id -u)" = 0 ] && return 0
  command -v sudo >/dev/null || return 1
  sudo -n true 2>/dev/null || [ -t 0 ]
}

# Prints what has to be installed by hand and stops.
stop_with_list() {
  echo "$1" >&2
  echo "Voile needs these packages (names of Debian 12):" >&2
  printf '  %s\n' $2 >&2
  echo "With all of them in place, VOILE_SKIP_INSTALL=1 skips this check." >&2
  exit 2
}

missing_packages() {
  local package
  for package in $1; do
    dpkg-query -W -f='${db:Status-Status}\n' "$package" 2>/dev/null | grep -qx installed || echo "$package"
  done
}

# install_packages "list": installs what is missing through apt.
install_packages() {
  [ "${VOILE_SKIP_INSTALL:-0}" = 1 ] && return 0
  local id="" version="" missing
  [ -r /etc/os-release ] && id=$(. /etc/os-release && echo "${ID:-}") && version=$(. /etc/os-release && echo "${VERSION_ID:-}")
  if [ "$id" != debian ] || ! command -v apt-get >/dev/null; then
    stop_with_list "This is not Debian, so nothing is installed automatically." "$1"
  fi
  [ "$version" = 12 ] || echo "note: Debian ${version:-(unknown version)}; Voile is developed on Debian 12" >&2
  missing=$(missing_packages "$1")
  [ -z "$missing" ] && return 0
  can_be_root || stop_with_list "Packages are missing, and installing them needs root or sudo. Missing:
$(printf '  %s\n' $missing)" "$1"
  say "installing" $missing
  as_root env DEBIAN_FRONTEND=noninteractive apt-get update -q
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $missing
}

# The reference BLAS is about ten times slower than OpenBLAS in the factorisation.
use_openblas() {
  command -v update-alternatives >/dev/null || return 0
  local arch library name current best
  arch=$(dpkg-architecture -qDEB_HOST_MULTIARCH 2>/dev/null || gcc -print-multiarch)
  for library in libblas.so.3 liblapack.so.3; do
    name="$library-$arch"
    current=$(update-alternatives --query "$name" 2>/dev/null | sed -n 's/^Value: //p')
    case "$current" in
      "" | *openblas*) continue ;;
    esac
    best=$(update-alternatives --list "$name" | grep openblas-pthread | head -1)
    if [ -n "$best" ] && [ "${VOILE_SKIP_INSTALL:-0}" != 1 ] && can_be_root; then
      say "making OpenBLAS the active $library"
      as_root update-alternatives --set "$name" "$best"
    else
      echo "warning: $library is $current, not OpenBLAS: factorisations will be slow." >&2
      echo "         update-alternatives --config $name changes it." >&2
    fi
  done
}

# One thread per rank; ranks may outnumber cores and yield them while they wait; containers run as root and do not allow
# reading other processes' memory.
set_environment() {
  export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
  export OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_hwloc_base_binding_policy=none
  export OMPI_MCA_mpi_yield_when_idle=1
  export OMPI_MCA_btl_vader_single_copy_mechanism=none
  if [ "$(id -u)" = 0 ]; then
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
  fi
}

# Compilers in parallel: one per core, but no more than one per 1.5 GB of memory.
build_jobs() {
  local cores memory
  cores=$(env -u OMP_NUM_THREADS nproc)  # nproc obeys that variable
  memory=$(awk '/^MemAvailable/ { print int($2 / 1500000) }' /proc/meminfo 2>/dev/null)
  [ "${memory:-1}" -lt 1 ] && memory=1
  [ "${memory:-$cores}" -lt "$cores" ] && echo "$memory" || echo "$cores"
}

# build_in FOLDER TARGET [CMake options]: configures and builds a target ("all" for everything).
build_in() {
  local folder="$1" target="$2" generator=()
  shift 2
  if [ ! -f "$folder/CMakeCache.txt" ]; then
    command -v ninja >/dev/null && generator=(-G Ninja)
    command -v ccache >/dev/null && generator+=(-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  fi
  # Without these, ccache does not serve files that use precompiled headers.
  export CCACHE_SLOPPINESS="${CCACHE_SLOPPINESS:-pch_defines,time_macros,include_file_mtime,include_file_ctime}"
  mkdir -p "$folder"
  cmake -S "$root" -B "$folder" "${generator[@]}" "$@" >"$folder/configure.log" 2>&1 || {
    cat "$folder/configure.log" >&2
    return 1
  }
  cmake --build "$folder" --target "$target" -j "$(build_jobs)"
}
