# Sourced by scripts/test and the like: counts what passes and what fails, and how long each thing takes.
#
# step NAME COMMAND…             one thing that passes or fails as a whole
# suite PRESET [ctest options…]  runs the preset's tests and adds up their numbers
# sanitized PRESET               builds a preset with a sanitizer, and runs its tests
# filtered PRESET PATTERN        only the tests whose name contains PATTERN
# totals                         a table of what took how long, and the last line, `N passed, N failed`; fails when something did

passed=0
failed=0
took=()

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

suite() {
  local preset=$1 log=build/$1/ctest.log results=build/$1/results
  shift
  rm -rf "$results"
  ctest --test-dir "build/$preset" --output-on-failure -j "${FLEETPUB_TEST_JOBS:-8}" "$@" </dev/null >"$log" 2>&1
  awk '/^ *[0-9]+\/[0-9]+ Test +#/ && !/ Passed /,/Start +[0-9]+:/' "$log"
  count_results "$results"
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
  printf '\n%s passed, %s failed\n' "$passed" "$failed"
  [ "$failed" -eq 0 ]
}
