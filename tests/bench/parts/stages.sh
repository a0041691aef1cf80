# Where the work is: what callgrind counts in the static binary, added up by stage.

# counted RUN ROBOTS COMMAND…
counted() {
  valgrind --tool=callgrind --collect-systime=nsec --callgrind-out-file="$home/callgrind" "${@:3}" <"$(names "$2")" >/dev/null 2>"$home/valgrind" ||
    { cat "$home/valgrind" >&2; return 1; }
  python3 tests/bench/stages.py "$home/callgrind" "$1" "$2" "$folder/$part.csv"
}
counted 'one shot' 1 $fleetpub pause KIT/000001 --vda 3.0 --no-check --quiet
counted '10,000 robots, sent at QoS 0' 10000 $fleetpub pause - --vda 3.0 --no-check --quiet
with_robots 10000 counted '10,000 robots, confirmed' 10000 $fleetpub pause - --wait --vda 3.0 --no-check --quiet
