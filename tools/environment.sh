# Shell library of the commands beside it: where things are, which interpreter and environment, and processes that end.
# Sourced, never run.

set -euo pipefail

ROOT=$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")
WORKSPACE=$ROOT/build  # the one name below a package that rosrun does not search for executables
NOETIC=/opt/ros/noetic/setup.bash

# Debian's python3 is the one that has ROS, whatever else is on PATH.
export PATH="/usr/bin:/bin:/usr/sbin:/sbin${PATH:+:$PATH}"
export LANG=${LANG:-C.UTF-8}
export MPLBACKEND=Agg
unset PYTHONHOME PYTHONPATH PYTHONSTARTUP VIRTUAL_ENV

# fail MESSAGE [CODE]: end with one line on stderr.
fail() {
  printf 'error: %s\n' "$1" >&2
  exit "${2:-1}"
}

# read_packages: fill KEYS and PACKAGES from the list.
read_packages() {
  local key names
  KEYS=() PACKAGES=()
  while read -r key names; do
    case $key in '' | '#'*) continue ;; esac
    KEYS+=("$key")
    # shellcheck disable=SC2206  # names is a list of words
    PACKAGES+=($names)
  done <"$ROOT/tools/packages.txt"
}

# use_core: what the library and the command line need; no ROS.
use_core() {
  # Packages that pip put into a home folder would come before Debian's; on Noetic, PuLP comes that way.
  [ -f "$NOETIC" ] || export PYTHONNOUSERSITE=1
  export PYTHONPATH=$ROOT/src${SOCIAL_FLEET_PYTHONPATH:+:$SOCIAL_FLEET_PYTHONPATH}
  use_compiled_code
}

# use_ros: what nodes, launch files and tests need, with a ROS master of our own beside any that runs.
use_ros() {
  [ -f "$WORKSPACE/devel/setup.bash" ] || fail "the workspace is not built: run $ROOT/tools/setup"
  use_core
  unset PYTHONPATH CMAKE_PREFIX_PATH ROS_PACKAGE_PATH ROS_NAMESPACE ROS_IP
  set +u
  # shellcheck disable=SC1091
  source "$WORKSPACE/devel/setup.bash"
  # Packages built from source elsewhere, such as global_planner, which some benchmarks and tests use where they are.
  # shellcheck disable=SC1091
  [ -z "${SOCIAL_FLEET_EXTRA_WORKSPACE:-}" ] || source "$SOCIAL_FLEET_EXTRA_WORKSPACE/devel/setup.bash" --extend
  set -u
  MASTER_PORT=$(free_port)
  export ROS_MASTER_URI=http://localhost:$MASTER_PORT ROS_HOSTNAME=localhost
  export PYTHONUNBUFFERED=1  # so that what nodes and roslaunch print keeps its order in a pipe
  export ROS_HOME=$WORKSPACE/ros ROS_LOG_DIR=$WORKSPACE/ros/log
  mkdir -p "$ROS_LOG_DIR"
  find "$ROS_LOG_DIR" -mindepth 1 -maxdepth 1 -mtime +7 -exec rm -rf {} +
}

# use_compiled_code: a cache for Numba that no edit makes stale. Numba looks at the edited file only, not at the
# functions of other files that it compiled in, so the folder's name holds a digest of all compiled sources.
use_compiled_code() {
  local cache=$WORKSPACE/cache/numba digest
  if ! mkdir -p "$cache" 2>/dev/null || [ ! -w "$cache" ]; then
    cache=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/social_fleet/numba
  fi
  export SOCIAL_FLEET_CACHE=${SOCIAL_FLEET_CACHE-${cache%/numba}/arrays}  # what planners precompute for a map
  digest=$(cd "$ROOT/src" && grep -rl --include='*.py' numba . | sort | xargs -r cat | sha256sum)
  export NUMBA_CACHE_DIR=$cache/${digest:0:16}
  if mkdir -p "$NUMBA_CACHE_DIR" 2>/dev/null && touch "$NUMBA_CACHE_DIR" 2>/dev/null; then
    # What was compiled of sources that nobody has run for long.
    find "$cache" -mindepth 1 -maxdepth 1 -type d -mtime +30 -exec rm -rf {} + 2>/dev/null || true
  else
    unset NUMBA_CACHE_DIR
  fi
}

# free_port: a TCP port that nothing listens on, below those that the kernel gives to outgoing connections.
free_port() {
  local port
  for _ in {1..100}; do
    port=$((20000 + (RANDOM * 32768 + RANDOM) % 12000))
    (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null || { echo "$port"; return; }
  done
  fail "found no free TCP port between 20000 and 32000"
}

# run_bounded SECONDS COMMAND...: run COMMAND and hand on its exit code; 124 past the deadline, 130 or 143 after a signal.
# Every process that COMMAND started is gone afterwards, also those that roslaunch put into sessions of their own.
run_bounded() {
  local deadline=$((SECONDS + $1)) mark=SOCIAL_FLEET_RUN=$$.$RANDOM$RANDOM code=0 stopped=0 child
  shift
  trap 'stopped=130' INT
  trap 'stopped=143' TERM HUP
  # Job control gives the command its own process group and the default SIGINT, so that it is we who pass on Ctrl-C.
  set -m
  env "$mark" "$@" </dev/null &
  child=$!
  set +m
  while ((!stopped)) && kill -0 "$child" 2>/dev/null; do
    ((SECONDS < deadline)) || stopped=124
    sleep 0.1 || true
  done
  if ((stopped)); then
    kill -INT "$child" 2>/dev/null || true
    await_end 25 kill -0 "$child" || true
  fi
  await_end 2 marked "$mark" || true
  marked "$mark" | xargs -r kill -KILL 2>/dev/null || true
  wait "$child" 2>/dev/null || code=$?
  trap - INT TERM HUP
  ((!stopped)) || code=$stopped
  return "$code"
}

# marked MARK: ids of the processes that carry the mark; fails when there are none.
marked() {
  grep -lzxsF -- "$1" /proc/[0-9]*/environ | cut -d/ -f3 | grep .
}

# await_end SECONDS CONDITION...: wait until the condition fails; fails when it still holds at the end.
await_end() {
  local deadline=$((SECONDS + $1))
  shift
  while "$@" >/dev/null 2>&1; do
    ((SECONDS < deadline)) || return 1
    sleep 0.1 || true
  done
}
