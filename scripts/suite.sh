# Sourced by scripts/test and the like: counts what passes and what fails.
#
# step NAME COMMAND…             one thing that passes or fails as a whole
# suite PRESET [ctest options…]  runs the preset's tests and adds up their numbers
# totals                         the last line, `N passed, N failed`; fails when something did

passed=0
failed=0

step() {
  local name=$1
  shift
  if "$@" </dev/null; then
    passed=$((passed + 1))
    echo "ok      $name"
  else
    failed=$((failed + 1))
    echo "FAILED  $name"
    return 1
  fi
}

suite() {
  local preset=$1 report=$PWD/build/$1/junit.xml
  shift
  rm -f "$report"
  ctest --test-dir "build/$preset" --output-on-failure -j "$(nproc)" --output-junit "$report" "$@" \
    </dev/null | grep -vE '^ *(Start +[0-9]+:|[0-9]+/[0-9]+ Test +#[0-9]+: .* Passed )'
  local all bad
  all=$(sed -n 's/^\t*tests="\([0-9]*\)"$/\1/p' "$report" 2>/dev/null | head -1)
  bad=$(sed -n 's/^\t*failures="\([0-9]*\)"$/\1/p' "$report" 2>/dev/null | head -1)
  if [ -z "$all" ] || [ "$all" -eq 0 ]; then
    echo "FAILED  no test ran in $preset"
    failed=$((failed + 1))
    return
  fi
  passed=$((passed + all - bad))
  failed=$((failed + bad))
}

totals() {
  echo "$passed passed, $failed failed"
  [ "$failed" -eq 0 ]
}
