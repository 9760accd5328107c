# Sourced by the tests of the program: PROGRAM SAMPLE-FOLDER are their arguments. Gives $program,
# $sample, a folder $work that goes at the end, the counts $passed and $failed, and two commands.

program=$1
sample=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
passed=0
failed=0

# expect CODE TEXT COMMAND...: the command ends with CODE and its output holds TEXT.
expect() {
  local code=$1 text=$2
  shift 2
  "$@" >"$work/log" 2>&1 </dev/null
  local status=$?
  if ((status == code)) && grep -qF -- "$text" "$work/log"; then
    passed=$((passed + 1))
  else
    failed=$((failed + 1))
    printf 'FAILED: %s\n  exit code %d, expected %d; expected to read "%s"; was:\n' "$*" "$status" "$code" "$text"
    sed 's/^/  /' "$work/log"
  fi
}

# check MESSAGE COMMAND...: the command succeeds.
check() {
  local message=$1
  shift
  if "$@"; then
    passed=$((passed + 1))
  else
    failed=$((failed + 1))
    printf 'FAILED: %s\n' "$message"
  fi
}
