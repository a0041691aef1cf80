# Sourced by scripts/test and the like: counts what passes and what fails, and how long each thing takes.
#
# step NAME COMMAND…             one thing that passes or fails as a whole
# suite PRESET [ctest options…]  runs the preset's tests and adds up their numbers; a few that fail run once more, alone
# sanitized PRESET               builds a preset with a sanitizer, and runs its tests
# filtered PRESET PATTERN        only the tests whose name contains PATTERN
# totals                         a table of what took how long, and the last line, `N passed, N failed`; fails when something did

passed=0
failed=0
took=()
only_alone=()

# timed NAME COMMAND…: as the command, and a line of the table.
timed() {
  local name=$1 start=$SECONDS code=0
  shift
  "$@" </dev/null || code=$?
  took+=("$(printf '%6d s    %s' $((SECONDS - start)) "$name")")
  return $code
}

step() {
  if timed "$@"; then
    passed=$((passed + 1))
    echo "ok      $1"
  else
    failed=$((failed + 1))
    echo "FAILED  $1"
    return 1
  fi
}

# Adds up what GoogleTest wrote, process by process.
count_results() {
  local folder=$1 file all bad
  for file in "$folder"/*.xml; do
    read -r all bad < <(sed -n 's/^<testsuites tests="\([0-9]*\)" failures="\([0-9]*\)".*/\1 \2/p' "$file" 2>/dev/null)
    passed=$((passed + ${all:-0} - ${bad:-0}))
    failed=$((failed + ${bad:-0}))
  done
}

# The failed tests in a file of results, as --gtest_filter takes them, one to a line.
failed_tests() {
  # The first attribute is the test's name, the last its group's.
  awk -F'"' '/<testcase / {test = $(NF - 1) "." $2} /<failure / {print test}' "$1" 2>/dev/null | uniq
}

# Beside seven others on a busy machine a test may fail by its own impatience. One to three that failed are run once more,
# alone, and count by what they do then; totals names them, since each is to be mended. What fails always fails twice.
once_more() {
  local preset=$1 results=$2 file test program
  local -a tests=()
  for file in "$results"/*.xml; do
    while read -r test; do tests+=("$(basename "${file%%_tests.*}")_tests $test"); done < <(failed_tests "$file")
  done
  # A property that a random value broke is not held because the next values keep it.
  if [ ${#tests[@]} -gt 3 ] || grep -qs Falsifiable "$results"/*.xml; then return 0; fi
  for test in "${tests[@]}"; do
    read -r program test <<<"$test"
    echo "once more, alone: $test"
    "build/$preset/tests/$program" --gtest_filter="$test" --gtest_brief=1 </dev/null || continue
    only_alone+=("$test")
    passed=$((passed + 1))
    failed=$((failed - 1))
  done
}

suite() {
  local preset=$1 log=build/$1/ctest.log results=build/$1/results
  shift
  rm -rf "$results"
  ctest --test-dir "build/$preset" --output-on-failure -j "${FLEETPUB_TEST_JOBS:-8}" "$@" </dev/null >"$log" 2>&1
  awk '/^ *[0-9]+\/[0-9]+ Test +#/ && !/ Passed /,/Start +[0-9]+:/' "$log"
  count_results "$results"
  once_more "$preset" "$results"
  local line name
  while read -r line; do
    name=$(awk '{print $4}' <<<"$line")
    took+=("$(printf '%8.1f s  %s' "$(grep -oE '[0-9.]+ sec' <<<"$line" | cut -d' ' -f1)" "  $name")")
    case "$line" in
      *' Passed '*) [ -e "$results/$name.xml" ] || passed=$((passed + 1)) ;;
      # One that names no failed test crashed, hung, or was stopped by a sanitizer.
      *) grep -q '<testsuites .* failures="[1-9]' "$results/$name.xml" 2>/dev/null ||
           { failed=$((failed + 1)); echo "FAILED  $name"; } ;;
    esac
  done < <(grep -E '^ *[0-9]+/[0-9]+ Test +#' "$log")
  if ! grep -qE '^ *[0-9]+/[0-9]+ Test +#' "$log"; then
    echo "FAILED  no test ran in $preset"
    failed=$((failed + 1))
  fi
}

sanitized() { step "build $1" scripts/build "$1" && timed "tests under $1" suite "$1"; }

filtered() {
  local program results=build/$1/results found=0
  rm -rf "$results"
  for program in unit_tests e2e_tests; do
    GTEST_OUTPUT=xml:$results/$program.xml "build/$1/tests/$program" --gtest_filter="*$2*" --gtest_brief=1 </dev/null
    found=$((found + $(sed -n 's/^<testsuites tests="\([0-9]*\)".*/\1/p' "$results/$program.xml")))
  done
  count_results "$results"
  [ "$found" -gt 0 ] || { echo "FAILED  no test is called so: $2"; failed=$((failed + 1)); }
}

totals() {
  printf '\nWhat took how long:\n'
  printf '%s\n' "${took[@]}"
  [ ${#only_alone[@]} -eq 0 ] || printf '%s\n' '' 'Failed beside others, passed alone, to be mended:' "${only_alone[@]/#/  }"
  printf '\n%s passed, %s failed\n' "$passed" "$failed"
  [ "$failed" -eq 0 ]
}
