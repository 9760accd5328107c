# shellcheck shell=bash
# Shared by the scripts of this folder; to be sourced, not run.

set -euo pipefail

ROOT="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
readonly ROOT

# Prints a heading to the standard error stream.
step() {
  printf '\n== %s\n' "$*" >&2
}

# Prints an error and stops.
die() {
  printf '%s: error: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

# Prints the comment block at the top of the calling script, which is its help.
usage() {
  sed -n '2,/^[^#]/{s/^# \{0,1\}//p}' "$0"
}

# Prints how many compilers to run at once: one per processor, and 1.5 GB of memory for each.
jobs() {
  local processors memory_kb by_memory
  processors="$(nproc)"
  memory_kb="$(awk '/^MemAvailable:/ {print $2}' /proc/meminfo)"
  by_memory=$((${memory_kb:-1500000} / 1500000))
  if ((by_memory < 1)); then by_memory=1; fi
  echo $((processors < by_memory ? processors : by_memory))
}

# Configures the preset $1, with the further arguments handed to cmake. Uses ccache where it is there.
configure() {
  local preset="$1"
  shift
  if command -v ccache >/dev/null; then export CMAKE_CXX_COMPILER_LAUNCHER=ccache; fi
  (cd "$ROOT" && cmake --preset "$preset" "$@")
}

# Builds the preset $1, with the further arguments handed to cmake --build.
build() {
  local preset="$1"
  shift
  (cd "$ROOT" && cmake --build --preset "$preset" -j "$(jobs)" "$@")
}
